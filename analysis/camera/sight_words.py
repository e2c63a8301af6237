"""The words by which `sight_rule` reads a text: what things are called, and what is said of seeing them."""

from __future__ import annotations

THINGS: dict[str, str] = {
    "logo": "logos?|logotype|emblems?|insignia|logotipo|logotyp|logótipo|emblema|emblème|логотип[а-я]*|эмблем[а-я]*"
    "|ロゴ(?:マーク)?|エンブレム|标志|標誌|标识|徽标|徽標|로고|엠블럼",
    "fire extinguisher": "(?:fire )?extinguishers?|feuerlöscher|extincteurs?|extintor(?:es)?|estintor[ei]"
    "|огнетушител[а-я]*|消火器|灭火器|滅火器|소화기",
    "water cooler": "water ?(?:coolers?|dispensers?)|wasserspender|(?:fontaine|distributeur) (?:à|d')? ?eau"
    "|dispensador de agua|bebedouros?|кулер[а-я]*|ウォーターサーバー|ウォータークーラー|饮水机|飲水機|정수기",
    "printer": "printers?|copiers?|photocopiers?|drucker|imprimantes?|impresoras?|impressoras?|stampant[ei]"
    "|принтер[а-я]*|プリンター?|コピー機|複合機|打印机|印表機|프린터",
    "whiteboard": "white ?boards?|whiteboardtafel|tableau blanc|pizarra(?: blanca)?|quadro branco|lavagna(?: bianca)?"
    "|маркерн[а-я]+ доск[а-я]*|ホワイトボード|白板|화이트보드",
    "refrigerator": "refrigerators?|fridges?|kühlschrank|réfrigérateurs?|frigos?|refrigerador|nevera|frigorífico"
    "|geladeira|frigorifero|холодильник[а-я]*|冷蔵庫|冰箱|냉장고",
    "coffee machine": "coffee ?(?:machines?|makers?)|espresso machines?|kaffeemaschine|machine à café|cafetière"
    "|cafetera|máquina de café|cafeteira|macchina del caffè|кофемашин[а-я]*|кофеварк[а-я]*"
    "|コーヒー(?:マシン|メーカー)|咖啡机|咖啡機|커피 ?(?:머신|메이커)",
    "sofa": "sofas?|couch(?:es)?|settees?|canapés?|sofás?|divan[oi]|диван[а-я]*|ソファー?|沙发|沙發|소파",
    "globe": "globes?|globus|globe terrestre|globo terráqueo|mappamondo|глобус[а-я]*|地球儀|地球仪|지구본",
    "safe": "safes?|strongbox|tresor|safe|coffre-fort|coffre|caja fuerte|cofre|cassaforte|сейф[а-я]*"
    "|金庫|保险箱|保险柜|금고",
    "picture": "pictures?|paintings?|artworks?|bild|gemälde|tableau|peinture|cuadro|pintura|quadro|dipinto"
    "|картин[а-я]*|絵画?|絵|作品|画|그림",
    "door": "doors?|doorway|tür|porte|puerta|porta|двер[а-я]*|ドア|扉|门|門|문",
    "table": "tables?|desks?|tisch|mesa|tavolo|стол[а-я]*|テーブル|机|桌子|테이블",
    "chair": "chairs?|stuhl|chaise|silla|cadeira|sedia|стул[а-я]*|椅子|いす|의자",
    "plant": "plants?|pflanze|plante|planta|pianta|растени[а-я]*|植物|观葉|식물",
    "window": "windows?|fenster|fenêtre|ventana|janela|finestra|окн[а-я]*|窓|窗户|창문",
    "lamp": "lamps?|ceiling lights?|light fixtures?|lampen?|leuchten?|lampes?|lámparas?|lâmpadas?|lampad[ae]|ламп[а-я]*"
    "|照明|ランプ|灯具|吊灯|조명|램프",
    "wall": "walls?|wand|wände|mur|murs|pared(?:es)?|paredes?|mur[oi]|pareti|стен[а-я]*|壁(?!紙)|墙壁?|牆|벽",
    "sign": "signs?|signage|placards?|schild(?:er)?|panneaux?|letreros?|placas?|cartell[oi]|табличк[а-я]*|标牌|指示牌"
    "|案内板|標識|看板|표지판",
    "cabinet": "cabinets?|cupboards?|aktenschrank|schränke?|schrank|armoires?|archivador(?:es)?|armários?|armadi(?:o)?"
    "|шкаф[а-я]*|キャビネット|戸棚|文件柜|柜子|櫃子|캐비닛",
    "notice board": "(?:notice|bulletin|cork|pin) ?boards?|pinnwand|tableau d'affichage|tablón|掲示板|公告板|布告栏"
    "|게시판",
    "sculpture": "sculptures?|statues?|skulptur(?:en)?|escultura|scultura|скульптур[а-я]*|彫刻|彫像|雕塑|雕像|조각상?",
    "hatch": "hatch(?:es)?|luken?|écoutilles?|escotillas?|escotilhas?|portell[oi]|люк[а-я]*|ハッチ|舱口|艙口|해치",
    "rack": "racks?|gestelle?|baies?|estantes?|scaffal[ei]|стойк[а-я]*|ラック|机架|机柜|랙",
    "laptop": "laptops?|notebook computers?|ordinateurs? portables?|portátil(?:es)?|ноутбук[а-я]*|ノート(?:パソコン|pc)"
    "|笔记本电脑|노트북",
    "handrail": "hand ?rails?|grab bars?|handläufe?|handlauf|mains? courantes?|pasamanos|corrimão|手すり|扶手|난간",
    "airlock": "air ?locks?|luftschleuse|sas|エアロック|气闸|에어록",
    "bag": "bags?|stowage bags?|taschen?|sacs?|bolsas?|borse?|сумк[а-я]*|バッグ|袋|가방",
    "glovebox": "glove ?box(?:es)?|グローブボックス|手套箱|글러브박스",
    "free flyer": "free[ -]?flyers?|flying robots?|フリーフライヤー",
    "person": "persons?|people|m[ae]n|wom[ae]n|humans?|astronauts?|menschen?|personen?|personnes?|personas?|человек"
    "|люди|人物|人間|人影|宇宙飛行士|行人|사람",
    "screen": "screens?|monitors?|televisions?|bildschirme?|écrans?|pantallas?"
    "|monitores|schermi?|экран[а-я]*|монитор[а-я]*|モニター?|スクリーン|屏幕|显示器|화면|모니터",
    "shelf": "shel(?:f|ves)|bookcases?|bookshel(?:f|ves)|regale?|étagères?|estanterías?|scaffalatur[ae]|полк[а-я]*"
    "|棚(?!卸)|本棚|书架|架子|선반",
    "box": "box(?:es)?|crates?|cartons?|kisten?|boîtes?|cajas?|caixas?|scatol[ae]|коробк[а-я]*|(?<![冰险険圾])箱(?!根)"
    "|盒子|상자",
    "bed": "beds?|bett(?:en)?|camas?|lett[oi]|кровать|ベッド|床铺|침대",
    "clock": "clocks?|uhr(?:en)?|horloges?|reloj(?:es)?|relógios?|orologi(?:o)?|часы|時計|时钟|시계",
    "trash can": "(?:trash|garbage|waste) ?(?:cans?|bins?|baskets?)|mülleimer|poubelles?|papeleras?|lixeiras?|ゴミ箱"
    "|垃圾桶|쓰레기통",
    "stairs": "stairs?|staircases?|stairways?|treppen?|escaliers?|escaleras?|escadas?|лестниц[а-я]*|階段|楼梯|계단",
}
"""What things are called, by their English name; alternatives of whole words. A name of several words is looked up
from its end: of `JAXA logo`, the last word is found here, and the first one stands for itself."""

AMBIGUOUS = ("safe", "picture", "box", "bag", "screen")
"""Things whose names are also said of what is not there: "it is safe to go", "the picture shows". They count as things
only where a scene is known to have them."""

THE_TARGET = (
    "(?:the|my|our) (?:target|goal object|target object)|das ziel|la cible|(?:el|mi) objetivo|o alvo|цель"
    "|ターゲット|目標物?|対象物?|目标|目標|목표물?"
)
"""What stands for the thing that is to be found, whatever it is."""

ARTICLES = "the|this|that|der|die|das|dieses|den|le|la|les|ce|cette|el|lo|este|esta|il|o|a|este|этот|эта"
"""Words before the last word of a name that make it stand for the whole: `the logo`."""

NOT: dict[str, str] = {
    "English": r"no|not|[a-z]+n't|cannot|cant|dont|never|without|neither|nor|none|nowhere|unable|fail(?:ed|s)? to"
    r"|nothing|hidden|obscured|blocked|occluded|out of (?:view|sight)|outside (?:of )?(?:my|the) view|absent|missing"
    r"|lost|yet to|invisible|hard to|instead of",
    "German": "kein[a-zäöü]*|nicht|nirgends|nirgendwo|ohne|nie",
    "French": "ne|n'|pas|aucune?|sans|jamais|ni|nulle part",
    "Spanish": "ningún|ninguna?|sin|nunca|tampoco",
    "Portuguese": "não|nenhuma?|sem|nem",
    "Italian": "non|nessuna?|nessun|senza|né",
    "Russian": "не|нет|ни|без|нигде|никак[а-я]*",
}
NOT_UNSPACED: dict[str, str] = {
    "Japanese": "見え(?:ません|ない|ず|なく|ておらず)|見当たら|見つから|見つけられ|見つけて(?:いない|おらず)|ありません"
    "|確認でき(?:ません|ない|ず|てい)|映って(?:いない|いません|おらず)|写って(?:いない|いません|おらず)"
    "|見て(?:いない|いません)|無い|なし|無く|なく|ない",
    "Chinese": "没有|没|沒有|沒|未|不(?=[能可见見在是])|看不|无法|無法|尚未",
    "Korean": "않|안 보|없|못",
}
"""What denies that a thing is seen."""

UNSURE: dict[str, str] = {
    "English": "if|whether|might|may|could|would|should|must|maybe|perhaps|possibly|probably|likely|presumably|until"
    "|unless|hope(?:fully)?|hoping|expect(?:ed|ing)?|assum(?:e|ing)|so that|in case|where is|know where|once|when"
    "|usually|typically|will (?:[a-z]+ )?(?:see|find|be|come)|earlier|previously|imagin(?:e|ing)|guess",
    "German": "vielleicht|möglicherweise|wahrscheinlich|vermutlich|könnte|wenn|falls|sollte|damit|bis",
    "French": "peut-être|probablement|pourrait|devrait|jusqu|quand|si",
    "Spanish": "quizás?|tal vez|probablemente|podría|debería|hasta|cuando",
    "Portuguese": "talvez|provavelmente|poderia|deveria|até|quando",
    "Italian": "forse|probabilmente|potrebbe|dovrebbe|finché",
    "Russian": "возможно|наверное|вероятно|может|если|пока",
}
UNSURE_UNSPACED: dict[str, str] = {
    "Japanese": "(?:見え|あ)(?:る|ます)?(?:と思|はず|可能性|かも|か(?=どうか|を|確)|でしょう|だろう|よう|まで"
    "|れば|たら)|かもしれ|だろう|でしょう|はず|可能性|思われ",
    "Chinese": "可能|也许|也許|或许|如果|应该|應該|是否|大概|直到",
    "Korean": "수도|것 같|아마|보이(?:면|도록|는지)|있을",
}
"""What makes it a guess, a wish, a condition or a memory."""

SEARCHED: dict[str, str] = {
    "English": "look(?:ing|s|ed)?(?: around)? for|search[a-z]*|find|finding|locate|locating|seek(?:ing)?"
    "|scan(?:ning)?(?: [a-z]+){0,3} for|hunt(?:ing)?"
    "|(?:to|better) (?:see|spot|identify|notice|detect|recogni[sz]e|view)"
    "|need(?:s|ed)?|want|try|trying|aim(?:ing)? (?:to|at|for)",
    "German": "such[a-zäöüß]*|finden|finde|um",
    "French": "cherch[a-zé]*|recherch[a-zé]*|trouver|pour|afin",
    "Spanish": "busc[a-zóá]*|encontrar|hallar|localizar|para",
    "Portuguese": "procur[a-z]*|encontrar|achar",
    "Italian": "cerc[a-z]*|trovare|per",
    "Russian": "ищу|искать|найти|поиск[а-я]*|чтобы",
}
SEARCHED_UNSPACED: dict[str, str] = {
    "Japanese": "探|捜|見つける|見つけたい|見つけよう|見つけ出|発見する|発見したい|確認する|確認したい|見たい|見るため",
    "Chinese": "寻找|尋找|找到(?![了])|搜索|搜寻|查找|为了|寻",
    "Korean": "찾기|찾아|찾으|찾는|찾을|찾고|찾도록",
}
"""What names a thing as one that is still to be found."""

HEADED_FOR: dict[str, str] = {
    "English": "towards?|approach(?:ing)?|closer to|nearer to|reach|(?:get|getting|go|going|move|moving|path|way|leads?"
    "|leading|points?|pointing|distance|directions?) to",
    "German": "zum|zur|richtung|näher[a-z]*",
    "French": "vers|approch[a-zé]*|rapproch[a-zé]*",
    "Spanish": "hacia|acerc[a-zéá]*",
    "Portuguese": "direção|aproxim[a-z]*",
    "Italian": "verso|avvicin[a-z]*",
    "Russian": "к|приближ[а-я]*|подойти|направля[а-я]*|сторону",
}
HEADED_FOR_UNSPACED: dict[str, str] = {
    "Japanese": "近づ|近寄|向か|接近|目指",
    "Chinese": "朝|向|靠近|接近|走向|前往",
    "Korean": "향해|향하|가까이|쪽으로|다가",
}
"""What names a thing as where to go."""

SEEN: dict[str, str] = {
    "English": "able to (?:see|spot)|see|sees|seen|seeing|spot|spots|spotted|notice[sd]?|observe[sd]?|recogni[sz]e[sd]?"
    "|identif(?:y|ied)|found|detect(?:ed)?|located|visible|in (?:my |clear |plain |full )?(?:view|sight)"
    "|(?:there|here|this|that|it)(?:'s| is| are)|shows?|showing|displays?|displaying|features?|contains?|reached"
    "|arrived at|facing|looking (?:directly |straight )?at|(?:i am|i'm) (?:[a-z]+ ){0,2}(?:at|near|next to|close to"
    "|beside|in front of)|in front of me(?: is)?|ahead(?: of me)? is",
    "German": "sehe|sieht|erkenne|entdeckt?|entdecke|gefunden|sichtbar|zu sehen|vor mir|da ist|hier ist|dort ist"
    "|befindet sich|hängt",
    "French": "vois|voit|aperçois|aperçoit|distingue|visible|il y a|voici|voilà|trouvé|repéré|devant moi|se trouve",
    "Spanish": "veo|se ve|observo|distingo|hay|encontré|encontrado|está|aparece|se encuentra",
    "Portuguese": "vejo|consigo ver|há|visível|avisto|encontrei",
    "Italian": "vedo|si vede|visibile|c'è|ecco|trovato|intravedo|scorgo|si trova",
    "Russian": "вижу|видно|виден|видна|видны|видим[а-я]*|наш[её]л|обнаруж[а-я]*|находится|вот",
}
SEEN_UNSPACED: dict[str, str] = {
    "Japanese": "見え|見つけました|見つけた|見つかりました|見つかった|発見し|確認でき|確認しました|あります|ある|映って"
    "|写って|視界に|(?:これ|それ|あれ)[はが]|到着し|見ている|見ています|見て(?:取|と)れ",
    "Chinese": "看到|看见|看見|见到|發現|发现|找到了|可见|可見|能看|[前面方里裡上处處边邊]有|就在|位于|位於|出现"
    "|在(?:我的?)?(?:正?前|左|右|墙|牆)",
    "Korean": "보입니다|보여|보인다|보이(?!지|면|도록|는지)|있습니다|있다|있어|있는|발견|찾았|확인",
}
"""What says that a thing is there to be seen, or was come to."""

PLACED = (
    r"(?:is|are|'s|lies|sits|hangs|appears|stands|remains)(?: (?:clearly|partly|partially|directly|now|still|just|also"
    r"|already|right|straight|about|very|currently|fully|easily|only|well|there))* (?:visible|in (?:my |clear |plain "
    r"|full )?(?:view|sight)|in front|in the|ahead|on|at|near|nearby|right|left|there|here|above|below|behind|close"
    r"|cent(?:er|re)d|mounted|located|placed|within|next to|to (?:the|my)|directly|straight|inside|beside|against"
    r"|\d)"
)
"""What says, behind the name of a thing, where it is."""
