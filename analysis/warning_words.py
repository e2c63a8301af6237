"""The words by which `analysis.warning_rule` reads a text: what stands for a fire, and what takes the warning back.

Every table is by language: alternatives of whole words, and, in the tables whose names end in `UNSPACED`, of patterns
that match anywhere, for scripts without blanks to go by. All is lower case. The tables of all languages are read
together.
"""

from __future__ import annotations

FIRE: dict[str, str] = {
    "English": "fires?|wildfires?|flames?|blazes?|blazing|ablaze|inferno|burn|burns|burned|burnt|burning|smoke|smoky"
    "|smou?ldering|evacuat(?:e|es|ed|ing|ion|ions)",
    "German": "feuers?|brände|großbrand|brennt|brennen|brennend[a-z]*|flammen|rauch|qualm|qualmt|lodert|evakuier[a-z]*"
    "|(?:der|den|dem|ein|einen|großer) brand|brand (?:bei|am|im|an|in)",
    "French": "feu|feux|incendies?|flammes?|fumées?|brûl[a-zé]*|évacu[a-zé]*",
    "Spanish": "fuegos?|incendios?|humo|humareda|(?:las|en) llamas|arde|arden|ardiendo|quema|queman|quemando"
    "|evacu[a-zéó]*",
    "Portuguese": "fogos?|incêndios?|fumaça|fumo|(?:as|em) chamas|ardendo|queima|queimando|evacu[a-zçãõ]*",
    "Italian": "fuoco|fuochi|incendio?|fumo|fiamme|brucia|bruciano|bruciando|evacua[a-z]*",
    "Russian": "пожар[а-я]*|огонь|огн[яюе]|огн[её]м|пламя|пламени|горит|горят|дым(?:а|у|ом|е)?|эвакуац[а-я]*"
    "|эвакуир[а-я]*",
    "Dutch": "vuur|vlammen|rook|brandt|(?:er is|is er|de|een) (?!geen )(?:[a-z]+ )?brand|(?<=geen )brand|brand (?:bij"
    "|in|op|naast|uitgebroken)"
    "|evacu[a-zë]*",
    "Polish": "pożar[a-zóą]*|ogień|ognia|ogniem|dym|dymu|dymem|płonie|płoną|płomieni[a-z]*|pal[ią] się|ewaku[a-zęąć]*",
}
FIRE_UNSPACED: dict[str, str] = {
    "Japanese": "火事|火災|火の手|火元|火の粉|(?<!噴)出火|発火|延焼|消火|燃え|燃焼|焦げ臭|炎上"
    "|(?<![肺脳胃腸])炎(?![症天])"
    "|(?<![禁喫])煙(?!草)|避難|(?<![花聖灯])火(?=[がはも]|を[見確発感]|から|に近)",
    "Chinese": "火灾|火災|起火|着火|失火|火情|火光|火焰|火势|火警|燃烧|燃燒|烟雾|浓烟|冒烟|疏散|撤离|撤離|避难"
    "|[大有的见到是]火(?![锅车腿鸡箭星柴山爆热花])|火(?=还|在|正|越|已|很)|[见到有]烟(?!花)",
    "Korean": "화재|불이야|(?<![가-힣])불(?:이(?!익|행|해)|을|은|도(?!저))|불길|화염|연기|대피",
}
"""What stands for a fire, smoke, flames or flight from them."""

OTHER_SENSE: dict[str, str] = {
    "English": "fire (?:drills?|exercises?|stations?|trucks?|engines?|extinguishers?|safety|exits?|escapes?|museum)"
    "|evacuation (?:drills?|exercises?|plans?)|(?:by|around|beside) (?:a|the) (?:warm|cosy|cozy|crackling) fire"
    "|(?:sit|sits|sitting|gather|relax|chat|warm up) (?:[a-z]+ )?(?:by|around|beside) (?:a|the) fire"
    "|(?:camp|bon|log) fires?|(?:play|playing) with fire|under fire|fire (?:away|up)|on fire (?:with|tonight)"
    "|(?:song|track|music|beat|album|outfit|food|coffee|idea|party)(?:'s| is| was)(?: [a-z]+)? fire"
    "|candle (?:flames?|smoke|burning)|old flame|(?:candles? |incense )burn(?:s|ing)?"
    "|burn(?:ed|t|ing)? (?:off )?(?:[a-z]+ )?(?:toast|calories|food|dinner|breakfast|tongue|fingers?|energy|bridges)"
    "|burning (?:with|question|questions|desire|curiosity|passion)|blazing (?:fast|hot|sun)"
    "|(?:to|for a|a quick|you|don't|not|who|i) smoke(?! (?:is|near|coming))|smoke (?:break|a|cigarettes?|free)",
    "German": "feuer und flamme|feuer für (?:[a-z]+ )?(?:kerzen?|zigaretten?)|rauch(?:en|er) verboten"
    "|(?:kerzen? )brenn(?:t|en)|brenne[n]? (?:darauf|vor neugier)",
    "French": "feux? (?:est |sont |passe au )?(?:rouges?|verts?|orange|tricolores?)|feux? d'artifice|feu de camp"
    "|petit feu|brûle (?:d'envie|de curiosité)|brûle d'impatience",
    "Spanish": "fuegos artificiales|fuego lento|(?:me )?quem[eé] la",
    "Portuguese": "fogos? de artifício|fogo baixo|fumo (?:um|cigarros?)",
    "Italian": "fuochi d'artificio|fuoco lento|a fuoco(?= (?:il|la|lo|i|le))|fumo (?:una|sigarette)",
    "Russian": "горит желанием|горю желанием|горит (?:свет|лампа|зел[её]ный|красный)",
    "Dutch": "in vuur en vlam|kampvuur|vuurwerk",
}
OTHER_SENSE_UNSPACED: dict[str, str] = {
    "Japanese": "消火器|火を通|火にかけ|火の車|火がつく|やる気に燃え|情熱に燃え|燃え(?:る想い|尽き症候群|ないゴミ"
    "|るゴミ)"
    "|(?:避難|消火|防火)訓練|タバコの(?:火|煙)|避難(?:経路|場所)の?(?:確認|図)",
    "Chinese": "灭火器|火车|大火锅|疏散演习|消防演习|很火(?=的|爆|热|，|,|。|$)",
    "Korean": "불을 (?:켜|끄)|대피 ?훈련|화재 ?훈련|소화기",
}
"""Expressions in which those words mean something else."""

NOT: dict[str, str] = {
    "English": r"no(?! (?:doubt|time|matter|café|norte|sul|leste|oeste|momento|caminho))|not(?! (?:only|just|far"
    "|sure))|[a-z]+n't(?! (?:know|only|just))|cannot"
    "|cant|dont|never|without|neither|nor|none|nobody|nothing|free of|free from|absence of",
    "German": "kein[a-zäöü]*|nicht(?! (?:nur|weit|sicher))|nirgends|nirgendwo|ohne|nie|niemand|weder|nichts",
    "French": "pas(?! (?:loin|seulement))|aucune?|sans|jamais|ni|nulle part|rien",
    "Spanish": "no(?! (?:solo|sólo|lejos))|ningún|ninguna?|sin|nunca|tampoco|nada|ni",
    "Portuguese": "não(?! (?:só|apenas|longe))|nenhuma?|nenhum|sem|nem|nunca|nada",
    "Italian": "non(?! (?:solo|lontano))|nessuna?|nessun|senza|né|mai|niente|nulla",
    "Russian": "не(?! (?:только|далеко))|нет|ни|без|нигде|никак[а-я]*|никто|ничего",
    "Dutch": "niet(?! (?:alleen|ver))|geen|nergens|zonder|nooit|niets|niemand",
    "Polish": "nie(?! (?:tylko|daleko))|nigdzie|bez|ani|żaden|żadn[a-zeą]*|nikt|nic",
}
NOT_UNSPACED: dict[str, str] = {
    "Japanese": "ません|(?<!危)(?<!違い)(?<!か)ない(?![でかほ方よ])|なかった|なく(?!て)|無い|なし|(?:見え|確認でき"
    "|起き)ず"
    "|異常なし",
    "Chinese": "没有|沒有|没|沒|未|无|無|不是|并非",
    "Korean": "없|않|못|아니|(?<![가-힣])안 ",
}
"""What denies."""

GO: dict[str, str] = {
    "English": "go|going|come|return|approach|enter|stay|staying|remain|get|getting|walk|move|head|visit|wait|linger"
    "|use|cross|pass|touch|ignore|forget|underestimate|escape|reach|breathe|be (?:near|close)|want to be"
    "|put|control|stop|extinguish|safe",
    "German": "hin|hingehen|gehen|geht|näher[a-z]*|zurück[a-z]*|betreten|bleiben|sicher|in die nähe",
    "French": "approch[a-zé]*|all(?:ez|er|ons|é|és)|va|vas|pass[a-zé]*|rest[a-zé]*|retourn[a-zé]*|entr[a-zé]*"
    "|ven[a-zé]*|reven[a-zé]*",
    "Spanish": "vay[a-zá]*|acer[a-zéqu]*|entr[a-zéó]*|pas[a-zéó]*|vuelv[a-z]*|volv[a-záé]*|qued[a-zé]*|regres[a-zé]*"
    "|ir",
    "Portuguese": "vá|vão|ir|aproxim[a-z]*|entr[a-z]*|pass[a-z]*|volt[a-z]*|fiqu[a-z]*|ficar",
    "Italian": "and(?:at|ar|iam)[a-z]*|avvicin[a-z]*|entr[a-z]*|pass[a-z]*|torn[a-z]*|rest[a-z]*|veni[a-z]*",
    "Russian": "подход[а-я]*|ход[а-я]*|ид[а-я]*|приближ[а-я]*|возвращ[а-я]*|вход[а-я]*|остав[а-я]*|стой[а-я]*",
    "Dutch": "heen|gaan|naar|dichter[a-z]*|dichtbij|blijven|terug[a-z]*|veilig",
    "Polish": "id(?:ź|źcie|ę|ą|zie|ziemy)|podchod[a-zź]*|zbliż[a-z]*|wchod[a-zź]*|wraca[a-zć]*",
}
"""What one is told not to do, or cannot, where there is a fire: denied, it takes no warning back."""

FORBIDDEN: dict[str, str] = {
    "German": "(?:geht?|komm|kommt|nähert euch|bleibt?|betretet) (?:[a-zäöü]+ ){0,2}nicht",
    "French": "(?:approch|all|pass|rest|retourn|entr|ven|reven)[a-zé]*(?:-vous)? pas|va pas",
    "Dutch": "(?:ga|kom|blijf) (?:[a-z]+ )?niet",
}
FORBIDDEN_UNSPACED: dict[str, str] = {
    "Japanese": "ないで|ない(?:ほう|方|よう)|かもしれ(?:ない|ません)|知れません|しかありません|危ない"
    "|(?:安全|大丈夫)(?:な[^。]{0,4})?(?:では?|じゃ)(?:ない|ありません)|(?:では?|じゃ)ないか",
    "Korean": "지 ?(?:마|말)|않는 ?(?:게|것이)|않도록|안전하지 (?:않|못)",
    "Chinese": "不安全|没人|还没人",
}
"""Denials that are none: what not to do, and what may be."""

OVER: dict[str, str] = {
    "English": r"(?:is|are|was|'s|been|went|gone|burn(?:ed|t)|died)(?: (?:now|already|finally|all|completely))* out"
    r"(?! of)|(?:is|are|was|'s)(?: (?:now|already|finally|all))* over(?! (?:here|there|by|at|the|near|to|in|\d))"
    "|(?:was|were|been|is|are|got|have|has|they|already|finally) put out|put (?:it|that|the fire) out|extinguished"
    "|doused|no longer(?! safe)|any ?more|all clear|coast is clear|false alarm|(?:is|are|'s|has|have) gone|cleared"
    "|(?:be|was|is|were) (?:false|untrue|unfounded)|disappeared|stopped burning|nothing to worry",
    "German": "gelöscht|erloschen|ausgegangen|vorbei|nicht mehr|fehlalarm|entwarnung|(?:feuer|brand) ist aus",
    "French": "éteinte?s?|terminée?|fausse alerte|plus (?:de|d'|aucun|aucune)|maîtrisée?|n'y a plus",
    "Spanish": "apag(?:aron|ado|ada|ó)|extingui[a-zóí]*|ya no|falsa alarma|terminó|sofocado",
    "Portuguese": "apagad[oa]s?|apagaram|apagou|extint[oa]s?|já não|alarme falso|não há mais|acabou",
    "Italian": "spent[oaie]|spegnuto|estint[oa]|falso allarme|non c'è più|finit[oa]",
    "Russian": "потуш[а-яё]*|погас[а-я]*|больше нет|закончил[а-я]*|ложная тревога|ликвидирован[а-я]*",
    "Dutch": "geblust|gedoofd|uit is|is uit|niet meer|voorbij|vals alarm",
    "Polish": "uga[sś][a-zćłę]*|zgas[a-zł]*|już nie|fałszywy alarm|skończył[a-z]*",
}
OVER_UNSPACED: dict[str, str] = {
    "Japanese": "消え|鎮火|消火(?:され|しま|した|済|でき)|消し止め|消しました|消した|収ま|おさま|もう(?:安全|大丈夫)"
    "|誤報|治ま",
    "Chinese": "扑灭|撲滅|熄灭|熄滅|灭了|滅了|灭掉|结束|解除|控制住|误报|谣言|散了",
    "Korean": "꺼졌|꺼지|껐|진화|진압|끝났|해제|오보",
}
"""What says that it is over, or never was."""

UNTIL: dict[str, str] = {
    "English": "until|till|before|trying to|to be",
    "German": "bis|bevor",
    "French": "jusqu'à|avant",
    "Spanish": "hasta|antes",
    "Portuguese": "até|antes",
    "Italian": "finché|prima",
    "Russian": "пока|прежде",
    "Dutch": "tot|voordat",
    "Polish": "dopóki|zanim",
}
UNTIL_UNSPACED: dict[str, str] = {"Japanese": "まだ", "Chinese": "还没|還沒|尚未|直到", "Korean": "아직"}
"""What makes the end one that is still to come."""

PAST: dict[str, str] = {
    "English": "yesterday|last (?:night|week|month|year|summer|winter)|(?:days|weeks|months|years) ago|used to"
    "|once upon"
    "|(?:was|were) (?:fighting|rebuilt)",
    "German": "gestern|letzte[nrs]? (?:nacht|woche|monat|jahr)|früher|damals",
    "French": "hier (?:soir|matin|il|le|on|j'ai|nous)|(?:éteint|incendie|feu|était) hier|(?:semaine|année"
    "|nuit) dernière|(?:mois|an) dernier|autrefois",
    "Spanish": "ayer|anoche|(?:semana|noche) pasada|(?:mes|año) pasado|hace (?:años|meses|semanas|días)",
    "Portuguese": "ontem|(?:semana|noite) passada|(?:mês|ano) passado|há (?:anos|meses|semanas|dias)",
    "Italian": "ieri|(?:settimana|notte) scorsa|(?:mese|anno) scorso|tempo fa",
    "Russian": "вчера|на прошлой неделе|в прошлом (?:году|месяце)|раньше",
    "Dutch": "gisteren|vorige? (?:week|maand|jaar|nacht)|vroeger",
    "Polish": "wczoraj|w zeszłym (?:tygodniu|miesiącu|roku)|kiedyś",
}
PAST_UNSPACED: dict[str, str] = {
    "Japanese": "昨日|先週|先月|昨年|去年|昔|以前",
    "Chinese": "昨天|昨晚|上周|上个月|去年|以前|曾经",
    "Korean": "어제|지난 ?(?:주|달|해)|작년|예전",
}
"""What says that it was at another time."""

SUPPOSED: dict[str, str] = {
    "English": "if(?! you (?:are|want|can))|whether|in case|in the event|unless|imagine|suppose|books?|novel|films?"
    "|movie"
    "|story|stories|history|documentary|museum|dream(?:ed|t)?|poem|great fire of|(?:any|some) news|reports? of any",
    "German": "wenn|falls|ob|buch|roman|film|geschichte|traum|übung",
    "French": "si (?:tu|vous|on|jamais|un|une|quelqu'un)|s'il y a|au cas où|livre|roman|film|histoire|exercice",
    "Spanish": "si (?:ves|veis|ven|ve|hay|alguien|hubiera|notas)|en caso de|libro|novela|película|historia|simulacro",
    "Portuguese": "se (?:você|vocês|vir|virem|houver|alguém|notar)|caso|livro|romance|filme|história|simulado",
    "Italian": "se (?:vedi|vedete|c'è|ci|qualcuno|noti|notate)|nel caso|libro|romanzo|film|storia|esercitazione",
    "Russian": "если|ли|в случае|книг[а-я]*|роман|фильм[а-я]*|истори[а-я]*|учени[а-я]*",
    "Dutch": "als (?:je|jullie|er|iemand)|indien|of er|boek|verhaal|oefening",
    "Polish": "jeśli|jeżeli|gdyby|czy|książk[a-zęi]*|film[a-z]*|histori[a-zęi]*|ćwiczeni[a-z]*",
}
SUPPOSED_UNSPACED: dict[str, str] = {
    "Japanese": "もし|(?:あっ|起き|見かけ|見つけ|発生し|見)たら|場合|かどうか|映画|小説|物語|訓練|歴史|博物館|夢",
    "Chinese": "如果|要是|万一|是否|有没有|一旦|电影|小说|故事|演习|博物馆",
    "Korean": "만약|혹시|보면|보시면|있으면|나면|영화|소설|훈련",
}
"""What makes it a supposition, an indirect question or a tale, before the mention."""

STATED = (
    "there|here|i|i'm|i've|we|we're|it|it's|that|this|the|a|an|my|our|he|she|they|agent|watch|beware|careful|warning|be"
    "|es|ich|da|dort|hier|das|der|die|wir|il|je|j'ai|nous|on|le|la|les|un|une|vedo|ho|vejo|vi|eu|я|мы|там|er|ik|wij"
)
"""Words with which a statement begins that goes before a question in one sentence: "there is a fire, shall we go?"."""

ASKED_UNSPACED = "(?<!ません)(?<!ない)(?<!でしょ)か$|(?<!ない)でしょうか$|かな$|[吗嗎]|有没有|나요|까요|습니까"
"""What makes a clause a question without its mark."""

LINKS = (
    "but|and|so|because|since|while|although|though|however|as(?! chamas)|then|due to|und|aber|doch|denn|weil|sondern"
    "|et|(?<!há )mais|car"
    "|parce que|donc|y|pero|porque|así que|mas|então|(?<!nie )ma|perché|quindi|и|но|а|потому что|maar|want (?:er|het"
    "|de|ik)|en (?:ik|er|het|de|we|ga|kom|blijf)|ale|więc"
)
LINKS_UNSPACED = "(?<=[すただい])(?:が|けれども?|けど|ので|から|ため|し)|但是|但|所以|因此|而且|지만|니까|(?<=[다요]) "
"""What begins another clause."""
