"""The words by which `warning_rule` reads a text: what stands for a fire, and what only looks like it.

Every table is by language: alternatives of whole words, and, in the tables whose names end in `UNSPACED`, of patterns
that match anywhere, for scripts without blanks to go by. All is lower case. The tables of all languages are read
together.
"""

from __future__ import annotations

UNSPACED = ("Japanese", "Chinese", "Korean")
"""Languages whose patterns match anywhere."""

FIRE: dict[str, str] = {
    "English": "fires?|wildfires?|flames?|blazes?|blazing|ablaze|inferno|burn|burns|burned|burnt|burning"
    "|smoke|smoky|smou?ldering|evacuat(?:e|es|ed|ing|ion|ions)|alight|aflame|conflagration"
    "|engulfed in|smokes|smoking (?:ruins?|wreck|rubble)",
    "German": "feuers?|brände|großbrand|brennt|brennen|brennend[a-z]*|flammen|rauch|qualm|qualmt|lodert"
    "|evakuier[a-z]*|(?:der|den|dem|ein|einen|großer) brand|brand (?:bei|am|im|an|in)"
    "|brandgeruch|rauchig|verraucht|verqualmt|verbrannt|brandet|feuersbrunst|lichterloh"
    "|lodern|brandherd|qualmen",
    "French": "feu|feux|incendies?|flammes?|fumées?|brûl[a-zé]*|évacu[a-zé]*|brasier|roussi|embras[a-zé]*|enfumée?s?",
    "Spanish": "fuegos?|incendios?|humo|humareda|(?:las|en) llamas|arde|arden|ardiendo|quema|queman"
    "|quemando|evacu[a-zéó]*|incendi(?:a|an|ó|ado|ada|ando|aron)|quemad[oa]s?|humear?"
    "|humeante|prendió|prendido fuego",
    "Portuguese": "fogos?|incêndios?|fumaça|fumo|(?:as|em) chamas|ardendo|queima|queimando|evacu[a-zçãõ]*"
    "|labaredas?|incendi(?:ado|ada|ou|ando)|queimad[oa]s?|fumegando",
    "Italian": "fuoco|fuochi|incendio?|fumo|fiamme|brucia|bruciano|bruciando|evacua[a-z]*|incendiat[oa]"
    "|bruciat[oa]|rogo|ardono|infiamme",
    "Russian": "пожар[а-я]*|огонь|огн[яюе]|огн[её]м|пламя|пламени|горит|горят|дым(?:а|у|ом|е)?"
    "|эвакуац[а-я]*|эвакуир[а-я]*|гар(?:ь|и|ью)|горел(?:а|о|и|ым)?|задымлен[а-я]*"
    "|полыха[а-я]*|пыла(?:ет|ют)|загорел[аио]?с[ья]|возгоран[а-я]*|тлеет",
    "Dutch": "vuur|vlammen|rook|brandt|(?:er is|is er|de|een) (?!geen )(?:[a-z]+ )?brand"
    "|(?<=geen )brand|brand (?:bij|in|op|naast|uitgebroken)|evacu[a-zë]*|in brand|brandlucht"
    "|brandende?|verbrand|smeult|vlam|rookt|rookwolk[a-z]*|rookgeur"
    "|er (?:nog )?brand(?! geen)",
    "Polish": "pożar[a-zóą]*|ogień|ognia|ogniem|dym|dymu|dymem|płonie|płoną|płomieni[a-z]*|pal[ią] się"
    "|ewaku[a-zęąć]*|pali się|się (?:nie )?pal[ią]|spalenizn[a-zęą]*|dymi|zadymion[a-z]*"
    "|płon[a-zęą]*|płomie[nń]|zapalił[a-z]* się|tli się|ogniu",
}
FIRE_UNSPACED: dict[str, str] = {
    "Japanese": "火事|火災|火の手|火元|火の粉|(?<!噴)出火|発火|延焼|消火|燃え|燃焼|焦げ臭|炎上"
    "|(?<![肺脳胃腸])炎(?![症天])|(?<![禁喫])煙(?!草)|避難|(?<![花聖灯])火(?=[がはも]"
    "|を[見確発感]|から|に近)|焦げ(?=[たて臭く]|る?(?:臭|にお|匂))|きな臭|くすぶ|火の海"
    "|ぼや(?:騒ぎ|が|です)|ボヤ|小火|(?<!日)(?<!夕)(?<!胸)焼け(?=て|落ち)|燃や|黒煙|白煙",
    "Chinese": "火灾|火災|起火|着火|失火|火情|火光|火焰|火势|火警|燃烧|燃燒|烟雾|浓烟|冒烟|疏散|撤离"
    "|撤離|避难|[大有的见到是]火(?![锅车腿鸡箭星柴山爆热花])|火(?=还|在|正|越|已|很)"
    "|[见到有]烟(?!花)|着了火|(?<![燃发])烧(?![烤开饭菜脑酒鸡鸭肉卖水])|焦味|糊味"
    "|(?<![吸抽禁香烽])烟(?![花草火囱])|大火(?!锅)|火海|烈火",
    "Korean": "화재|불이야|(?<![가-힣])불(?:이(?!익|행|해)|을|은|도(?!저))|불길|화염|연기|대피"
    "|불타(?!는 ?(?:금|밤|열정|청춘|주말))|불에 ?타|타고 있|타는 냄새|탄내|탄 냄새"
    "|(?<![가-힣])불 ?[났나]|불붙|그을음",
}
"""What stands for a fire, smoke, flames or flight from them."""

PICTURED = "🔥 {0,3}(?:at|in|near|by|on|@|von|am|im|au|en|em|no|na)(?![a-z])"
"""The picture of a fire, with a place behind it: alone it may be praise."""

FLEE: dict[str, str] = {
    "English": "(?<!to )(?<!i )(?<!we )(?<!will )(?<!'ll )(?<!must )(?<!should )(?<!can )(?<!could )(?<!let's )(?:leave"
    "|clear|vacate|exit) (?:the [a-z]+|it|here|there|this place|that place"
    "|your [a-z]+) (?:now|immediately|at once|right away|right now|this instant|quickly|asap)"
    "|(?<!to )(?<!i )(?<!we )(?<!will )(?:leave|get out|get away) (?:immediately|at once"
    "|right now|asap)|get out(?: now|!+ )(?!of my)|get out of (?:the [a-z]+|there"
    "|here) (?:now|immediately|at once|right now|fast|quickly|asap)|run for (?:your"
    "|ur) (?:life|lives)|(?:everyone|everybody)(?: must| needs to| has to| should| please"
    "|,)? (?:(?:get )?out(?! (?:and|with|for|tonight|here))|leave(?: the [a-z]+"
    "| here)? (?:now|immediately|at once))|save yoursel(?:f|ves)",
    "German": "(?:verlasst|verlassen sie|verlass) (?:sofort|umgehend|jetzt)|sofort (?:raus|weg)"
    "|alle raus|(?:verlasst|verlassen sie|verlass) (?:das|die|den) [a-zäöüé]+ (?:sofort|jetzt"
    "|umgehend)|rennt um euer leben",
    "French": "(?:quittez|sortez|fuyez)(?: (?:de |du |la |le |les |l'){0,3}[a-zé]+)? (?:immédiatement"
    "|tout de suite|maintenant|vite|sans délai)|tout le monde dehors|sauve qui peut",
    "Spanish": "(?:salgan|salid|huyan|huid|abandonen|abandonad)(?: (?:de |del |la "
    "|el ){0,3}[a-zéíó]+)? (?:inmediatamente|ya|ahora mismo|ahora|de inmediato)|todos fuera"
    "|sálvese quien pueda",
    "Portuguese": "(?:saiam|fujam|abandonem)(?: (?:do |da |de |o |a ){0,3}[a-zéíóã]+)? (?:imediatamente|já"
    "|agora|agora mesmo)|todos para fora",
    "Italian": "(?:uscite|fuggite|scappate|lasciate)(?: (?:dal |dalla |da |il "
    "|la ){0,3}[a-zàèì]+)? (?:immediatamente|subito|ora|adesso)|tutti fuori",
    "Russian": "(?:срочно|немедленно|сейчас же|быстро) (?:покиньте|уходите|выходите|бегите|покидайте)"
    "|(?:покиньте|уходите|выходите|бегите)(?: (?:из |от )?[а-яё]+)? (?:немедленно|срочно"
    "|сейчас же)|все на улицу|все наружу",
    "Dutch": "(?:verlaat|ga weg uit) (?:de |het )?[a-zé]+ (?:onmiddellijk|nu|meteen)|iedereen (?:eruit"
    "|naar buiten)|onmiddellijk (?:weg|naar buiten)|ren voor je leven",
    "Polish": "(?:natychmiast|szybko) (?:opuść|opuśćcie|uciekajcie|uciekaj|wychodźcie)|(?:opuść"
    "|opuśćcie) [a-zęąłńóśźż]+ natychmiast|wszyscy na zewnątrz",
}
FLEE_UNSPACED: dict[str, str] = {
    "Japanese": "(?:今すぐ|すぐに?|直ちに|ただちに|至急)[^。!?、]{0,12}(?:出て|逃げて|離れて|脱出して"
    "|退避して)(?:くだ|下さ|!|。|$)|逃げろ|逃げて(?:ください|!|。|$)",
    "Chinese": "(?<!我)(?<!们)(?<!要)(?<!会)(?:马上|立即|立刻|赶紧|赶快|快)(?:离开|逃|跑出|撤)",
    "Korean": "(?:당장|즉시|빨리|어서) ?[^.!?]{0,12}(?:나가|나오|떠나|벗어나|도망치|피하)(?:세|십|라|요!|!)",
}
"""What tells to get away so urgently that it needs no reason."""

SHUN: dict[str, str] = {
    "English": "(?<!'ll )(?<!will )(?<!to )avoid|(?:stay|keep|steer|get) (?:well )?(?:away|clear|out"
    "|off)|stay back from|(?:do not|don't|dont|never) (?:go|come|walk|step|move|enter|cross"
    "|pass|approach|stand|stay|linger)(?! from)",
    "German": "meidet|meide|weg von|haltet euch fern von|abstand (?:zu|von)|geht nicht (?:nach|zu)|betretet nicht",
    "French": "évite[zr]?|éloignez-vous de|n'approchez pas de|n'allez pas (?:en|vers)|restez loin de",
    "Spanish": "evit(?:en|ad|a|e)|aléj[a-zéó]* de|alejaos de|no (?:vayan|vayáis|vayas|pasen|paséis"
    "|pases) (?:a|por|hacia)",
    "Portuguese": "evit(?:em|e|a)|afastem-se de|fiquem longe de|não (?:vão|vá|passem) (?:a|para|por)",
    "Italian": "evit(?:ate|a|i)|allontanatevi da|state lontani da|non (?:andate|passate"
    "|avvicinatevi) (?:a|da|per|verso)",
    "Russian": "избегайте|держитесь подальше от|не (?:ходите|подходите|идите) (?:к|на|в)|обходите",
    "Dutch": "vermijd|blijf (?:weg|uit de buurt)|ga niet naar|kom niet (?:bij|in de buurt van)",
    "Polish": "unikaj(?:cie)?|omijaj(?:cie)?|trzymaj(?:cie)? się z dala od|nie (?:idź|idźcie"
    "|podchodźcie|zbliżajcie się) (?:do|na|w)",
}
"""What makes a position, right behind it, one to keep away from."""

HAZARD: dict[str, str] = {
    "English": "(?:hazards?|hazardous|danger|dangers|dangerous|deadly|lethal)(?! of)|(?:not"
    "|n't)(?: at all| really| very)? safe|unsafe|too hot to|emergency|(?:lost|losing|lose"
    "|took|taking|take)(?: [a-z]+){0,3} (?:health|hp|life|lives|damage)|(?:it|that|this|spot"
    "|cell|place|area|heat) (?:hurts|kills)|killed|scorching|unbearably hot|life-threatening"
    "|death trap|deathtrap",
    "German": "gefahr|gefährlich[a-z]*|tödlich[a-z]*|lebensgefahr|lebensgefährlich|nicht sicher|notfall"
    "|notlage|viel zu heiß|zu heiß",
    "French": "danger|dangereu[a-z]*|mortel[a-z]*|pas sûr|urgence|trop chaud",
    "Spanish": "peligro|peligros[oa]s?|mortal|no es segur[oa]|emergencia|demasiado calor|demasiado caliente",
    "Portuguese": "perigo|perigos[oa]s?|mortal|não é segur[oa]|emergência|quente demais|muito quente",
    "Italian": "pericolo|pericolos[oaie]|mortale|non è sicur[oa]|emergenza|troppo caldo",
    "Russian": "опасн[а-я]*|смертельн[а-я]*|небезопасн[а-я]*|экстренн[а-я]*|тревога|чрезвычайн[а-я]*|слишком жарко",
    "Dutch": "gevaar|gevaarlijk[e]?|dodelijk|levensgevaarlijk|niet veilig|onveilig|noodgeval|te heet",
    "Polish": "niebezpiecz[a-zńą]*|zagrożeni[a-z]*|śmierteln[a-z]*|nie jest bezpiecz[a-z]*|za gorąco",
}
HAZARD_UNSPACED: dict[str, str] = {
    "Japanese": "危険|危ない|非常事態|緊急事態|緊急です|命に関わ|安全では(?:ない|ありません)|熱すぎ|ダメージ",
    "Chinese": "危险|危險|致命|紧急情况|不安全|太热|掉血",
    "Korean": "위험|비상(?!구)|긴급|안전하지 (?:않|못)|너무 뜨거|치명",
}
"""What stands for a fire where a position stands beside it, or where the message tells to get away."""

ESCAPE: dict[str, str] = {
    "English": "run(?! (?:into|out of|by|for the bus|a|the|low))|flee|fleeing|get (?:out|away|back)"
    "|(?:everyone|everybody|all of you|all) out|out of (?:there|here)|get everyone out"
    "|(?:leave|clear|vacate|exit) (?:the [a-z]+ |it |here |there |now|immediately|at once"
    "|everyone)|stay (?:away|clear|back|out)|keep (?:away|out|clear|back|your distance"
    "|a distance|at least|off|everyone)|avoid|escape|turn (?:around|back)|go around"
    "|steer clear|back off|head (?:away|elsewhere)|move away|do not (?:go|come|enter|walk"
    "|stay|approach|pass|cross|stand)|(?:don't|dont) (?:go|come|enter|walk|stay|approach|pass"
    "|cross|stand)|never (?:go|enter)|(?:save|protect) yourself|take cover",
    "German": "weg (?:von|da|hier|dort)|flieht|lauft|lauf|rennt|renn|raus|meidet|meide"
    "|haltet (?:euch )?(?:abstand|fern)|verlasst|verlassen sie|umgeht|geht nicht|nicht (?:hin"
    "|betreten|weiter)|kommt nicht",
    "French": "fuyez|fuis|sortez|sors|évite[zr]?|éloigne[a-z-]*|n'approche[a-z-]*|ne (?:passez|allez"
    "|venez|restez|va|viens|passe) pas|quittez|courez|cours|contournez|partez",
    "Spanish": "huy[a-z]*|huid|sal(?:gan|id|ga)|corr(?:an|ed|e)|evit[a-zéóá]*|aléj[a-zéó]*|alej[a-zéóá]*"
    "|no (?:vay[a-zá]*|pas[a-zéá]*|entr[a-zéá]*|os acer[a-zéqu]*|se acer[a-zéqu]*"
    "|te acer[a-zéqu]*)|abandon[a-zéá]*|rode[a-zé]*",
    "Portuguese": "fuj[a-z]*|foge|saiam|saia|evit[a-z]*|afast[a-z-]*|não (?:vão|vá|pass[a-z]*|entr[a-z]*"
    "|se aproxim[a-z]*)|abandon[a-z]*|corr(?:am|e)|contorn[a-z]*",
    "Italian": "scapp[a-z]*|fugg[a-z]*|usc(?:ite|i)|evit[a-z]*|allontan[a-z]*|non (?:andat[a-z]*"
    "|pass[a-z]*|entr[a-z]*|avvicin[a-z]*)|corr(?:ete|i)|lasciate|aggirat[a-z]*",
    "Russian": "бегите|беги|уходите|уходи|выходите|избега[а-я]*|держитесь|держись|покиньте|спасайтесь"
    "|обходите|обойдите|не (?:ходите|подходите|идите|заходите|приближайтесь|стойте)",
    "Dutch": "vlucht|ren|rennen|blijf (?:daar )?weg|vermijd|ga (?:daar )?weg|verlaat|weg daar|kom niet"
    "|ga niet|uit de buurt|loop om|maak dat je wegkomt",
    "Polish": "uciekaj[a-z]*|wychod[a-zź]*|unikaj[a-z]*|nie (?:idź[a-z]*|podchod[a-zź]*|wchod[a-zź]*"
    "|zbliżaj[a-z]*)|trzymaj[a-z]* się z dala|opuś[a-zć]*|omijaj[a-z]*|biegnij[a-z]*|z dala",
}
ESCAPE_UNSPACED: dict[str, str] = {
    "Japanese": "逃げ|離れて|離れろ|近づかない|近づくな|近寄らない|近寄るな|行かない(?:で|ほう|方)|行くな"
    "|入らない|避けて|避けろ|脱出|退避|立ち去|迂回|外へ出て|外に出て",
    "Chinese": "快跑|快逃|逃|远离|遠離|离开|離開|避开|避開|别(?:过|去|靠|来|进|往)|不要(?:过|去|靠|来|进"
    "|往)|绕|快走|跑",
    "Korean": "도망|피하|피해|떨어져|떨어지|가지 ?마|오지 ?마|나가|나오|벗어나|돌아가|접근하지|대피",
}
"""What tells to get away, or not to come."""

OTHER_SENSE: dict[str, str] = {
    "English": "fire (?:drills?|exercises?|stations?|trucks?|engines?|extinguishers?|safety|exits?"
    "|escapes?|museum)|evacuation (?:drills?|exercises?|plans?)|(?:by|around|beside) (?:a"
    "|the) (?:warm|cosy|cozy|crackling) fire|(?:sit|sits|sitting|gather|relax|chat"
    "|warm up) (?:[a-z]+ )?(?:by|around|beside) (?:a|the) fire|(?:camp|bon|log) fires?"
    "|(?:play|playing) with fire|under fire|fire (?:away|up)|on fire (?:with|tonight)|(?:song"
    "|track|music|beat|album|outfit|food|coffee|idea|party)(?:'s| is| was)(?: [a-z]+)? fire"
    "|candle (?:flames?|smoke|burning)|old flame|(?:candles? |incense )burn(?:s|ing)?"
    "|burn(?:ed|t|ing)? (?:off )?(?:[a-z]+ )?(?:toast|calories|food|dinner|breakfast|tongue"
    "|fingers?|energy|bridges)|burning (?:with|question|questions|desire|curiosity|passion)"
    "|blazing (?:fast|hot|sun)|(?:to|for a|a quick|you|don't|not|who|i) smoke(?! (?:is|near"
    "|coming))|smoke (?:break|a|cigarettes?|free)|(?:fire|smoke|flame|hazard|danger"
    "|burn)s?[- ]free|fire (?:sales?|pits?|dancers?|codes?|doors?|hydrants?|emojis?|ants?"
    "|insurance|wood|signs?|shows?|breath[a-z]*|breathers?|opals?)|fire(?: and| &) (?:ice"
    "|brimstone)|(?:hold|cease|friendly|open|cross|hell|quick)[- ]fire|fire (?:off|at will)"
    "|light(?:s|ed)? a fire under|like (?:a )?(?:house on fire|wildfire)"
    "|add(?:ing)? fuel to the fire|where there's smoke|(?:no )?smoke without fire"
    "|smoke(?: and |s and )mirrors|smoke (?:signals?|machines?|detectors?|rings?)"
    "|holy smokes?|chain smokes?|smoky (?:eyes?|whisk(?:e)?y|flavou?r|taste|voice|bbq|jazz"
    "|tea|cheese|blues|notes?|paprika|bacon)|blaze(?:s)? of [a-z]+|blaz(?:e|ed|ing) (?:a|the"
    "|new) trails?|trail-?blaz[a-z]*|in a blaze|(?:straight|pure|absolute|so|pretty|totally"
    "|total) fire|(?:is|are|was|'s|looks?|sounds?|tastes?) fire(?= *(?:[!,.;)]|$|bro|tho"
    "|though|fr|today|tonight))|(?:mouth|tongue|lips|cheeks|ears|legs|muscles|heart|soul|face"
    "|brain|feet|thighs|calves)(?: (?:is|are|was|feels?|literally|just|set"
    "|still)){0,3} (?:in flames|on fire|burning|ablaze|burns?)|(?:he|he's|she|she's|you"
    "|you're|u|ur|they're|band|dj|barista|waiter|chef|cook|baker|singer|player|team|dancer"
    "|pianist|drummer|guitarist|chat|crowd|dance floor|party|choir|comedian|writer|chess club"
    "|striker|goalie|poet|poker face)(?: (?:is|are|was|were|has been|have been|really|totally"
    "|absolutely|literally|just|so|truly)){0,3} on fire|on fire (?:hoy|heute|ce soir"
    "|aujourd'hui|oggi|vandaag|dziś|hoje)"
    "|"
    "(?<!library is )(?<!library's )(?<!cafe is )(?<!cafe's )(?<!café is )(?<!café's )"
    "(?<!bar is )(?<!bar's )(?<!park is )(?<!park's )(?<!museum is )(?<!museum's )"
    "(?<!building is )(?<!building's )(?<!house is )(?<!house's )(?<!kitchen is )(?<!kitchen's )"
    "on fire (?:today"
    "|lately|this (?:week|season|month)|these days|recently|at (?:chess|darts|pool|karaoke"
    "|poker|ping pong))|set(?:s|ting)? (?:the )?(?:stage|dance floor|world|charts|internet"
    "|crowd|hearts?) (?:on fire|ablaze|alight)|burn(?:s|ed|t"
    "|ing)? (?:[a-z]+ )?(?:the midnight oil|rubber|cds?|dvds?|daylight|cash|money|a hole|cake"
    "|cookies|pancakes|coffee|pizza|popcorn|rice|sauce|the candle|fat)|burning (?:love"
    "|ambition|ears|man|need|issues?|topics?|sensation|up with|to (?:know|tell|ask))"
    "|burn(?:ing)? (?:with|for)|(?:i'm|i am|feel|feeling|so|totally|bit) burn(?:ed|t) out"
    "|money to burn|slow burn|sick burn|(?:get(?:ting)? on|going) like a house on fire"
    "|flames? of (?:love|passion|hope|youth)|(?:eternal|olympic|twin) flames?"
    "|flame[- ](?:grilled|war|wars)|dante's inferno|(?:no|not|stop|quit|quitting|stopped"
    "|without|gave up|never|a|like to|want to|came out to|went out to|out for a"
    "|go(?:ing)?(?: out)? for a) smok(?:e|es|ing)(?= *(?:[!,.;?)]|$|in|at|here|indoors|inside"
    "|anymore|any more|when))|smoke[sd]? (?:weed|a |cigars?|cigarettes?|pipes?|salmon|meat"
    "|ham)|(?:candle|incense|stove|oven|grill|barbecue|bbq|toaster|fireplace)(?:s|'s)? (?:is "
    "|are )?(?:burning|smoke|fire|flames?|smoking)|fire (?:in (?:(?:the|a|our"
    "|its) )?(?:fireplace|hearth|stove|grate|eyes?|belly|heart|soul))|(?:cosy|cozy|crackling"
    "|roaring|warm|lovely) fires?(?= (?:in|at|by|going|and))|campfires?|bonfires?"
    "|fire[- ](?:departments?|brigades?|services?|chief|eaters?|eating|jugglers?|juggling)"
    "|any (?:signs? of |sort of |kind of |nearby |new |other |potential |possible "
    "|active ){0,3}(?:fires?|smoke|flames?|burning)|potential fires|(?:report|reporting"
    "|detect|detecting|spot|spotting|alert for|vigilant for|eye out for|lookout for"
    "|check(?:ing)? for|search(?:ing)? for|scan(?:ning)? for|look(?:ing)? for"
    "|monitor(?:ing)? for|(?:tell|warn|inform|alert|notify)(?:ing)? (?:others|people|you"
    "|everyone|them|each other|other agents) about|afraid of|scared of|fear of|case of"
    "|(?:must|to|should|will|i'll|and|can) avoid) (?:any |all |potential |possible |nearby "
    "|signs of ){0,3}(?:fires?|smoke|flames)(?= *(?:[.!,;)]|$|and|or|if|when|i|while|to))"
    "|(?<!the )(?<!this )(?<!that )(?<!these )fires? (?:is|are|can be) (?:always |so |very "
    "|really )?(?:scary|dangerous|bad|deadly|terrible|no joke|hot|unpredictable|frightening"
    "|serious)|(?:any|potential|possible|out of|other|avoid|signs? of|for) (?:potential "
    "|possible |other |nearby |any ){0,3}(?:hazards?|dangers?)|(?:sky|horizon|clouds?|leaves"
    "|stars?)(?: (?:is|are|was|seems?|looks?|all|just)){0,3} (?:ablaze|on fire|burning|aflame"
    "|in flames)|(?:warm|cosy|cozy)(?: and (?:warm|cosy|cozy))? (?:by|at|near) (?:the|a) fire"
    "|(?:fires?|smoke|flames)(?: detected| seen| status)? ?[:=] ?(?:no|none|false|0|nil"
    "|negative|n/a)(?= *(?:$|[,.;})!]))",
    "German": "feuer und flamme|feuer für (?:[a-z]+ )?(?:kerzen?|zigaretten?)|rauch(?:en|er) verboten"
    "|(?:kerzen? )brenn(?:t|en)|brenne[n]? (?:darauf|vor neugier)|feuertaufe|kaminfeuer"
    "|lagerfeuer|feuerwerk[a-z]*|feuerwehrfest|(?:am|ums|beim) (?:warmen )?feuer"
    "|brennende? frage[n]?|brenn(?:e|t|en) (?:vor|für|auf|darauf)|feuer (?:im"
    "|in den) (?:herzen|blut|augen|kamin)|(?:heute|echt|voll|total|richtig) (?:on fire|feuer)"
    "|mit dem feuer|feuerpause|(?:feuer|rauch)frei|feuerlöscher|feueralarmübung"
    "|brandschutzübung|(?:mund|zunge|beine|wangen|muskeln) brenn(?:t|en)|rauchverbot"
    "|eine rauchen|zu rauchen",
    "French": "feux? (?:est |sont |passe au )?(?:rouges?|verts?|orange|tricolores?)|feux? d'artifice"
    "|feu de camp|petit feu|brûle (?:d'envie|de curiosité)|brûle d'impatience|feu (?:vert"
    "|tricolore|follet|de cheminée|de joie|d'artifice)|tout feu tout flamme|cessez-le-feu"
    "|coups? de feu|brûl[a-zé]* (?:les étapes|des calories|de te |de vous |d'impatience)"
    "|flammes? (?:olympique|de la passion|d'amour)|(?:es|est|suis|sommes|êtes|sont"
    "|était) (?:vraiment |complètement )?(?:en feu|au top)(?= (?:aujourd'hui|ce soir|sur"
    "|ce matin))|(?:ambiance|soirée|fête|groupe|dj|barista|équipe|chanteuse|chanteur)(?: est"
    "| était)?(?: vraiment| carrément)? (?:en feu|de feu)|jouer avec le feu"
    "|mettre le feu (?:à la piste|à la salle|à la soirée)|une fumée|pause fumée|sans fumée"
    "|non-fumeurs?|question brûlante|au coin du feu|dans la cheminée",
    "Spanish": "fuegos artificiales|fuego lento|(?:me )?quem[eé] la|que arde|quem(?:ar|ando"
    "|a) (?:calorías|etapas|grasa)|ard(?:o|e|iendo|er) (?:de|en) (?:deseos?|ganas|amor"
    "|curiosidad)|alto el fuego|a fuego|con fuego|fuego (?:de campamento|en (?:el corazón"
    "|la mirada)|cruzado|amigo)|en llamas (?:hoy|esta noche)|libre de (?:humo|fuego)s?"
    "|pregunta ardiente|(?:equipo|barista|dj|grupo|cantante|banda)(?: está"
    "| estuvo)?(?: hoy)? (?:en llamas|on fire|que arde)|es puro fuego|pausa para fumar"
    "|(?:junto|frente) al fuego|me quemé la|chimenea",
    "Portuguese": "fogos? de artifício|fogo baixo|fumo (?:um|cigarros?)|(?:festa|show|balada|dj|banda"
    "|barista)(?: (?:tá|está|estava|hoje)){0,3} (?:pegando fogo|em chamas|que arde|on fire)"
    "|com fogo|queima(?:r)? (?:calorias|de fogos|gordura)|ard(?:e|endo|o) de (?:desejo"
    "|vontade|curiosidade)|fogueira|cessar-fogo|livre de (?:fumo|fumaça|fogo)"
    "|é fogo(?= *[!,.]|$)|lareira|fogo (?:no coração|no olhar|amigo)",
    "Italian": "fuochi d'artificio|fuoco lento|a fuoco(?= (?:il|la|lo|i|le))|fumo (?:una|sigarette)"
    "|(?:festa|serata|dj|barista|band)(?: è| era)?(?: oggi)? (?:di fuoco|in fiamme"
    "|infuocat[ao]|che spacca)|col fuoco|con il fuoco|cessate il fuoco|bruci(?:o|are"
    "|ando) (?:dalla voglia|dal desiderio|calorie|le tappe)|davanti al fuoco"
    "|fuoco (?:di paglia|di bivacco|amico|nel cuore|nel camino)|falò|mettere a fuoco"
    "|vietato fumare|zona senza fumo|caminetto",
    "Russian": "горит желанием|горю желанием|горит (?:свет|лампа|зел[её]ный|красный)"
    "|глаза(?: [а-я]+)? гор[а-я]*|гор[яи]т? глаза|(?:трек|песня|вечеринка|музыка|кофе|танцы"
    "|концерт|бариста|команда)(?: сегодня| просто| реально|,| -| —| –){0,3} (?:огонь|огнище"
    "|жжёт|в огне)|гор(?:ю|им|ишь) (?:желанием|нетерпением|от)|костр[а-я]*|камин[а-я]*"
    "|линия огня|играть с огн[её]м|сгора[а-я]* от (?:нетерпения|стыда|любопытства)"
    "|дыма? без огня|с огоньком",
    "Dutch": "in vuur en vlam|kampvuur|vuurwerk|haardvuur|(?:met|het) vuur spel[a-z]*|vuurdoop"
    "|brandende (?:vraag|kwestie|nieuwsgierigheid)|brand(?:t|en)? van (?:verlangen"
    "|nieuwsgierigheid)|rookvrij[e]?|brandvrij|(?:barista|dj|band|team|feestje)(?: is"
    "| staat)?(?: vandaag| echt)? (?:on fire|in vuur en vlam|in brand)|staakt-het-vuren"
    "|open haard|rookpauze|brandoefening|bij het vuur",
    "Polish": "(?:ogień|płomień) w (?:oczach|sercu)|pali mi się do|fajerwerk[a-zió]*|(?:barista|dj"
    "|drużyna|impreza|zespół)(?: jest)?(?: dziś| dzisiaj)? (?:w ogniu|on fire|ogień)"
    "|igra[a-zć]* z ogniem|ognisk[a-zou]*|kominek|kominku|przy ogniu|pali(?:sz|ć"
    "|ł)? papieros[a-zy]*|płon(?:ę|ie) z (?:ciekawości|niecierpliwości)|zawieszenie ognia"
    "|dymu bez ognia",
}
OTHER_SENSE_UNSPACED: dict[str, str] = {
    "Japanese": "消火器|火を通|火にかけ|火の車|火がつく|やる気に燃え|情熱に燃え|燃え(?:る想い|尽き症候群"
    "|ないゴミ|るゴミ)|(?:避難|消火|防火)訓練|タバコの(?:火|煙)|避難(?:経路|場所)の?(?:確認"
    r"|図)|(?:心|やる気|闘志|情熱|恋|ハート|胸)(?:に|の|は|が|を)(?:火|炎|燃)[^、。!?\s]{0,8}"
    "|(?:バリスタ|選手|チーム|監督|店員|シェフ|DJ|dj|彼女|彼|私|僕|俺|君|あなた|みんな|先生"
    "|歌手|バンド)(?:は|が|も|たち[はがも])、?(?:今日|今|最近|今夜|本当|最高"
    r"|絶好調){0,3}(?:に|は|も)?燃え[^、。!?\s]{0,6}|焚き火|たき火|暖炉|弱火|強火|中火|火加減"
    "|火を(?:止め|弱め|強め|入れ)|キャンプファイヤー?|燃え(?:るような|る思い|尽き)|(?:sns"
    r"|ネット|ツイッター|twitter|投稿|コメント欄)[がはでの]{0,2}(?:大)?炎上[^、。!?\s]{0,6}"
    r"|火のない所に煙[^、。!?\s]{0,6}|炎の(?:ような|料理人|ゴール)|避難訓練|防災(?:訓練|の日)"
    "|非常口|禁煙|喫煙(?:所|室|席)?|分煙|対岸の火事|肉が焼け|魚が焼け|パンが焼け|ケーキが焼け"
    "|(?:曲|歌|試合|展開|ライブ|アニメ|漫画|音楽|演奏)(?:は|が|も"
    "|って)?[^。、]{0,4}燃え[^。、!?]{0,4}",
    "Chinese": "灭火器|火车|大火锅|疏散演习|消防演习|很火(?=的|爆|热|，|,|。|$)|(?:最近|特别|超级?|好|真"
    "|太|非常|超|挺|越来越|这么|那么)火(?![灾災势势焰大光场情警])|火爆|火热|火辣|发火|恼火"
    "|红火|(?<![着起失大救有])火了(?=[,。!]|$)|火锅|烟花|烟火|(?:好|太|真|超)燃|燃起来|火气"
    "|上火|怒火|点燃(?:了)?(?:激情|热情|希望|全场)|热情如火|停火|(?:禁|抽|吸|香)烟|烟民"
    "|无烟(?:区|餐厅|咖啡)?|炉火|篝火|烟消云散|燃烧(?:卡路里|脂肪|激情|的心)|烧(?:烤|钱|脑)"
    "|风风火火|玩火|纸包不住火|如火如荼|消防(?:栓|站|车|员|门)|防火(?:墙|门)|安全出口",
    "Korean": "불을 (?:켜|끄)|대피 ?훈련|화재 ?훈련|소화기|불금|불타는 ?(?:금요일|밤|열정|청춘|주말"
    "|토요일|사랑)|불태[우워][^.,!?]{0,6}|불꽃놀이|(?:의욕|열정|마음|가슴"
    "|승부욕)[이가에은는]?[ ]?불[^.,!?]{0,6}|불닭|불고기|불낙|모닥불|벽난로|캠프파이어"
    "|가스 ?불|촛불|금연|담배 ?연기|연기(?:자|력|를 (?:잘|정말|참)|가 (?:좋|훌륭|뛰어|대단))"
    "|배우[^.,!?]{0,6}연기|불조심|소방(?:관|차|서|훈련)|방화벽|불을 (?:켜|끄|줄)|불 좀 (?:켜"
    "|꺼)|발등에 불|불구경|(?:공연|무대|분위기|노래|파티|경기)[^.,!?]{0,8}불타[^.,!?]{0,6}",
}
"""Expressions in which those words mean something else."""
