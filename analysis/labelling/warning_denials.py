"""The words by which `warning_rule` takes a mention of a fire back; tables as in `warning_words`."""

from __future__ import annotations

NOT: dict[str, str] = {
    "English": "zero|no(?! (?:doubt|time|matter|café|norte|sul|leste|oeste|momento|caminho))"
    "|not(?! (?:only|just|far|sure))|[a-z]+n't(?! (?:know|only|just))|cannot|cant|dont|never"
    "|without|neither|nor|none|nobody|nothing|free of|free from|absence of",
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
    "Japanese": "ません|(?<!危)(?<!違い)(?<!か)ない(?![でかほ方よ])|なかった|なく(?!て)|無い|なし|(?:見え"
    "|確認でき|起き)ず|異常なし",
    "Chinese": "没有|沒有|没|沒|未|无|無|不是|并非",
    "Korean": "없|않|못|아니|(?<![가-힣])안 ",
}
"""What denies."""

GO: dict[str, str] = {
    "English": "go|going|come|return|approach|enter|stay|staying|remain|get|getting|walk|move|head|visit"
    "|wait|linger|use|cross|pass|touch|ignore|forget|underestimate|escape|reach|breathe"
    "|be (?:near|close)|want to be|put|control|stop|extinguish|safe",
    "German": "hin|hingehen|gehen|geht|näher[a-z]*|zurück[a-z]*|betreten|bleiben|sicher|in die nähe",
    "French": "approch[a-zé]*|all(?:ez|er|ons|é|és)|va|vas|pass[a-zé]*|rest[a-zé]*|retourn[a-zé]*"
    "|entr[a-zé]*|ven[a-zé]*|reven[a-zé]*",
    "Spanish": "vay[a-zá]*|acer[a-zéqu]*|entr[a-zéó]*|pas[a-zéó]*|vuelv[a-z]*|volv[a-záé]*|qued[a-zé]*"
    "|regres[a-zé]*|ir",
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
    "English": "(?:is|are|was|'s|been|went|gone|burn(?:ed|t)|died)(?: (?:now|already|finally|all"
    "|completely)){0,3} out(?! of)|(?:is|are|was|'s)(?: (?:now|already|finally"
    r"|all)){0,3} over(?! (?:here|there|by|at|the|near|to|in|\d))|(?:was|were|been|is|are|got"
    "|have|has|they|already|finally) put out|put (?:it|that) out|extinguished|doused"
    "|no longer(?! safe)|any ?more|all clear|coast is clear|false alarm|(?:is|are|'s|has"
    "|have) gone|cleared|(?:be|was|is|were) (?:false|untrue|unfounded)|disappeared"
    "|stopped burning|nothing to worry|put (?:it|them|that|this) out|put(?= (?:the|this"
    "|that) (?:fires?|flames|blaze) out)|(?:fire|blaze|smoke)'s (?:now |already |finally "
    "|all ){0,3}(?:out|over|gone)(?! of)|(?:we|they|he|she|i|firefighters|crew|someone"
    "|brigade)(?: have| has| just| finally| already| all){0,3} put out the|died (?:down|out)"
    "|burn(?:ed|t) itself out|itself out|quenched|smothered|snuffed out|long out|fully out"
    "|completely out|hoax|prank|just kidding|was (?:kidding|joking|a joke)|only a joke",
    "German": "gelöscht|erloschen|ausgegangen|vorbei|nicht mehr|fehlalarm|entwarnung|(?:feuer"
    "|brand) ist aus|(?:feuer|brand|flammen) (?:ist|sind|ging|gingen) (?:jetzt |schon "
    "|wieder |endlich ){0,3}aus|gebannt|falscher alarm|blinder alarm|(?<=nicht )(?:aus"
    "|aus gewesen)(?= *[,.!]|$)",
    "French": "éteinte?s?|terminée?|fausse alerte|plus (?:de|d'|aucun|aucune)|maîtrisée?|n'y a plus|circonscrit",
    "Spanish": "apag(?:aron|ado|ada|ó)|extingui[a-zóí]*|ya no|falsa alarma|terminó|sofocado|extinto|apagamos",
    "Portuguese": "apagad[oa]s?|apagaram|apagou|extint[oa]s?|já não|alarme falso|não há mais|acabou|apagámos|dominado",
    "Italian": "spent[oaie]|spegnuto|estint[oa]|falso allarme|non c'è più|finit[oa]|domato",
    "Russian": "потуш[а-яё]*|погас[а-я]*|больше нет|закончил[а-я]*|ложная тревога|ликвидирован[а-я]*"
    "|затуш[а-яё]*|уже не горит",
    "Dutch": "geblust|gedoofd|uit is|is uit|niet meer|voorbij|vals alarm|onder controle",
    "Polish": "uga[sś][a-zćłę]*|zgas[a-zł]*|już nie|fałszywy alarm|skończył[a-z]*|opanowan[a-z]*|stłumion[a-z]*",
}
OVER_UNSPACED: dict[str, str] = {
    "Japanese": "消え|鎮火|消火(?:され|しま|した|済|でき)|消し止め|消しました|消した|収ま|おさま"
    "|もう(?:安全|大丈夫)|誤報|治ま",
    "Chinese": "扑灭|撲滅|熄灭|熄滅|灭了|滅了|灭掉|结束|解除|控制住|误报|谣言|散了|救下来了",
    "Korean": "꺼졌|꺼지|껐|진화|진압|끝났|해제|오보|잡혔",
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
UNTIL_UNSPACED: dict[str, str] = {
    "Japanese": "まだ",
    "Chinese": "还没|還沒|尚未|直到",
    "Korean": "아직",
}
"""What makes the end one that is still to come."""

PAST: dict[str, str] = {
    "English": "yesterday|last (?:night|week|month|year|summer|winter)|(?:days|weeks|months|years) ago"
    "|used to|once upon|(?:was|were) (?:fighting|rebuilt)|long ago|ages ago|back in|back when"
    "|as a (?:child|kid|boy|girl)|when i was|in (?:18|19|20)[0-9][0-9]|the other (?:day|week)"
    "|(?:a|one|two|three) (?:day|week|month|year)s? ago|last (?:spring|autumn|fall|january"
    "|february|march|april|may|june|july|august|september|october|november|december|monday"
    "|tuesday|wednesday|thursday|friday|saturday|sunday)|once (?:burn[a-z]*|had)|years back"
    "|centur(?:y|ies)|decades?",
    "German": "gestern|letzte[nrs]? (?:nacht|woche|monat|jahr)|früher|damals|vor (?:langer zeit"
    "|(?:vielen |einigen |ein paar |zwei |drei )?(?:jahren|wochen|tagen|monaten)"
    "|einem (?:jahr|monat)|einer woche)|einst|(?:im|voriges|letztes) jahr|letzten (?:sommer"
    "|winter|herbst)|als kind",
    "French": "hier (?:soir|matin|il|le|on|j'ai|nous)|(?:éteint|incendie|feu|était) hier|(?:semaine"
    "|année|nuit) dernière|(?:mois|an) dernier|autrefois|il y a (?:longtemps|(?:quelques "
    "|deux |trois |dix |des )?(?:ans|années|mois|semaines|jours)|un (?:an|mois)|une semaine)"
    "|l'année dernière|l'an dernier|jadis|l'été dernier|quand j'étais",
    "Spanish": "ayer|anoche|(?:semana|noche) pasada|(?:mes|año) pasado|hace (?:años|meses|semanas|días)"
    "|hace (?:[a-z]+ )?(?:tiempo|años?|mes(?:es)?|semanas?|días?)|antiguamente|el (?:verano"
    "|invierno) pasado|cuando era niñ[oa]",
    "Portuguese": "ontem|(?:semana|noite) passada|(?:mês|ano) passado|há (?:anos|meses|semanas|dias)"
    "|há (?:[a-zé]+ )?(?:tempo|anos?|mês|meses|semanas?|dias?)|antigamente|(?:verão"
    "|inverno) passado|quando eu era",
    "Italian": "ieri|(?:settimana|notte) scorsa|(?:mese|anno) scorso|tempo fa|(?:[a-z]+ )?(?:anni|mesi"
    "|settimane|giorni) fa|un (?:anno|mese) fa|una settimana fa|molto tempo fa|una volta"
    "|(?:estate|inverno) scors[ao]|da bambin[oa]",
    "Russian": "вчера|на прошлой неделе|в прошлом (?:году|месяце)|раньше|давным-давно|(?:[а-я]+ )?(?:лет"
    "|года?|недел[юи]|месяц[а-я]*|дн(?:я|ей)) назад|в прошлый раз|прошл(?:ым летом|ой зимой)"
    "|когда-то|в детстве",
    "Dutch": "gisteren|vorige? (?:week|maand|jaar|nacht)|vroeger|(?:lang|jaren|weken|maanden"
    "|dagen) geleden|een (?:jaar|week|maand) geleden|ooit|vorige zomer|als kind",
    "Polish": "wczoraj|w zeszłym (?:tygodniu|miesiącu|roku)|kiedyś|dawno temu|niegdyś"
    "|(?:[a-z]+ )?(?:lat|lata|tygodni|miesięcy|dni) temu|(?:rok|tydzień|miesiąc) temu"
    "|zeszłej (?:zimy|nocy)|zeszłego (?:lata|roku)|w dzieciństwie|przed laty",
}
PAST_UNSPACED: dict[str, str] = {
    "Japanese": "昨日|先週|先月|昨年|去年|昔|以前|先日|一昨日|おととい|昨夜|昨晩|かつて|年(?:も|ほど)?前"
    "|(?:か|ヶ)月前|週間前|日前|子供の(?:頃|ころ)|当時",
    "Chinese": "昨天|昨晚|上周|上个月|去年|以前|曾经|很久以前|多年前|(?:年|个月|天|周)前|前年|上次"
    "|小时候|古代|从前|前几天",
    "Korean": "어제|지난 ?(?:주|달|해)|작년|예전|옛날|오래 ?전|년 ?전|개월 ?전|주일? 전에|일 전에"
    "|달 전에|몇 년 전|어젯밤|그저께|어렸을 때|지난번",
}
"""What says that it was at another time."""

SUPPOSED: dict[str, str] = {
    "English": "if(?! you (?:are|want|can))|whether|in case|in the event|unless|imagine|suppose|books?"
    "|novel|films?|movie|story|stories|history|documentary|dream(?:ed|t)?|poem|great fire of"
    "|(?:any|some) news|reports? of any|hypothetical(?:ly)?|in general|generally|in theory"
    "|fires? (?:can|could|may|might) (?:be|spread|start)|what if|chapters?|paintings?"
    "|legends?|myths?|tales?|lyrics|scenes?|dragons?|episodes?|(?:in|of) (?:my|the|this|a"
    "|that|our) (?:game|show|play|quest)|opera|anime|manga|podcasts?|practice|rehearsal"
    "|simulation|drills?|video ?game|board game|should (?:a|any|there)|were to|thriller|comic"
    "|trailer|rules? (?:for|say)|safety tips?|training",
    "German": "wenn|falls|ob|buch|roman|film|geschichte|museum(?:s)? (?:über|für|zum)|traum|übung"
    "|sollte (?:es|je|mal|einmal|ein)|falls|im notfall|kapitel|drache[n]?|krimi|oper|märchen"
    "|brettspiel|videospiel|grundsätzlich|im allgemeinen|generell|hypothetisch"
    "|gesetzt den fall",
    "French": "si (?:tu|vous|on|jamais|un|une|quelqu'un)|s'il y a(?:vait)?|au cas où|livre|roman|film"
    "|histoire|exercice|en cas de|si (?:un jour|jamais|quelque|le|la|les|ça)|chapitre|dragon"
    "|(?:un|le|ce) conte|opéra|jeu vidéo|série|polar|en général|imaginons|supposons",
    "Spanish": "si (?:ves|veis|ven|ve|hay|alguien|hubiera|notas)|en caso de|libro|novela|película"
    "|historia|simulacro|si (?:algún|alguna|algun|un día|una vez|hubiese|hay|pasa|llega|se"
    "|ocurre|el|la)|capítulo|dragón|(?:un|el|este) cuento|ópera|videojuego|serie|en general"
    "|imagina|supongamos|obra de teatro",
    "Portuguese": "se (?:você|vocês|vir|virem|houver|alguém|notar)|caso|livro|romance|filme|história"
    "|simulado|(?<!-)se (?:um dia|algum|alguma|algum dia|houvesse|acontecer|tiver|o|a)"
    "|capítulo|dragão|(?:um|o|este) conto|ópera|videojogo|jogo|série|em geral|imagina|imagine"
    "|suponha",
    "Italian": "se (?:vedi|vedete|c'è|ci|qualcuno|noti|notate)|nel caso|libro|romanzo|film|storia"
    "|esercitazione|se (?:un giorno|mai|dovesse|scoppia|scoppiasse|succede)|capitolo|drago"
    "|fiaba|opera|videogioco|serie|in generale|immagina|supponiamo|qualora",
    "Russian": "если|ли|в случае|книг[а-я]*|роман|фильм[а-я]*|истори[а-я]*|учени[а-я]*|если бы|глав[аеу]"
    "|дракон[а-я]*|сказк[а-я]*|опер[аеу]|игр[аеу]|сериал[а-я]*|вообще говоря|представь[а-я]*"
    "|допустим",
    "Dutch": "als (?:je|jullie|er|iemand)|indien|of er|boek|verhaal|oefening|mocht(?:en)?|in geval van"
    "|stel (?:dat|je)|hoofdstuk|draak|sprookje|roman|film|opera|spel|serie|over het algemeen"
    "|in het algemeen",
    "Polish": "jeśli|jeżeli|gdyby|czy|książk[a-zęi]*|film[a-z]*|histori[a-zęi]*|ćwiczeni[a-z]*|w razie"
    "|gdyby|gdy|rozdzia[lł][a-z]*|smoka|smoki|smokiem|smoku|bajk[a-ią]*|powieś[a-zć]*"
    "|oper[aze]|gr(?:ze|a komputerowa)|serial[a-u]*|zasadniczo|ogólnie|wyobraź",
}
SUPPOSED_UNSPACED: dict[str, str] = {
    "Japanese": "もし|(?:あっ|起き|見かけ|見つけ|発生し|見)たら|場合|かどうか|映画|小説|物語|訓練|歴史"
    "|博物館の|夢|(?:だ|か)と思った(?:ら|けど|が)|万が一|万一|仮に|いざという|漫画|アニメ"
    "|ゲーム|ドラマ|ドラゴン|一般に|一般的に|(?:起き|あっ|出)た(?:とき|時)",
    "Chinese": "如果|要是|万一|是否|有没有|一旦|电影|小说|故事|演习|博物馆(?:的|里)|假如|假设|倘若|漫画"
    "|动画|游戏|电视剧|巨龙|恶龙|一般来说|通常|书里|书中",
    "Korean": "만약|혹시|보면|보시면|있으면|나면|영화|소설|훈련|혹시라도|만일|(?:나|생기|있"
    "|일어나)(?:면|다면)|만화|애니|게임|드라마|(?<![가-힣])용이|일반적으로|책에",
}
"""What makes it a supposition, an indirect question or a tale, before the mention."""

HARM: dict[str, str] = {
    "English": "no (?:casualties|injuries|victims|deaths|panic|joke|drill|exaggeration|kidding|lie|cap"
    "|time (?:to|for)|way (?:out|in|through|past|around)|one(?: else)?(?: (?:is|was|has been"
    "|got|seems|here is))? (?:hurt|injured|harmed|dead|killed|trapped))|(?:nobody|no one"
    "|noone|none of us|neither of us)(?: else)?(?: (?:is|was|has been|got|seems|here is|were"
    "|are))? (?:hurt|injured|harmed|dead|killed|trapped|burned|burnt)|(?:i'm|i am|we're"
    "|we are|isn't|not|aren't) (?:not )?(?:hurt|injured|harmed)|unhurt|unharmed|(?:this is "
    "|it's |that's |it is |i'm |i am |am |we're )?not (?:a |an |just a |even )?(?:joke|drill"
    "|joking|kidding|test|exercise|exaggerating|lying|making this up|rumou?r|movie|film|good"
    "|fun|funny|pretty)|isn't (?:a |just a )?(?:joke|drill|test|exercise|rumou?r|movie|film)"
    "|ain't (?:a |no )?(?:joke|drill|lie)|without (?:warning|delay|panicking|panic"
    "|hesitation)|don't (?:panic|worry|be scared|wait)|do not (?:panic|wait)|couldn't believe"
    "|can't believe|never seen (?:such|anything|a)|nothing (?:serious|bad) happened to (?:me"
    "|us|anyone)",
    "German": "(?:niemand|keiner) (?:ist |wurde |wird )?(?:verletzt|zu schaden gekommen)"
    "|keine (?:verletzten|opfer|toten|panik|übung|zeit)|kein (?:scherz|witz|probealarm|test)"
    "|ohne (?:zögern|panik|vorwarnung)|nicht verletzt|unverletzt",
    "French": "personne n'(?:est|a été) (?:blessée?|touchée?)|(?:pas de|aucun|aucune) (?:blessés?"
    "|victimes?|panique)|sans blague|(?:ce )?n'est pas (?:un exercice|une blague)"
    "|pas (?:un exercice|une blague)|pas de panique|sans (?:attendre|délai|paniquer)",
    "Spanish": "no hay (?:heridos|víctimas|muertos|tiempo)|nadie (?:está|ha resultado|resultó"
    "|salió) herid[oa]|(?:ningún|sin) heridos?|no es (?:un simulacro|una broma|broma"
    "|un ejercicio)|sin (?:víctimas|demora|perder tiempo)|no (?:es )?broma",
    "Portuguese": "ninguém (?:se feriu|ficou ferido|está ferido|se machucou|se magoou)|não há (?:feridos"
    "|vítimas)|sem (?:feridos|vítimas|demora)|não é (?:um |uma )?(?:treino|exercício|simulado"
    "|brincadeira|piada)",
    "Italian": "ness(?:un|uno)(?: è| è rimasto| si è)? (?:ferito|fatto male)|non ci sono (?:feriti"
    "|vittime)|non è (?:un'esercitazione|uno scherzo|una prova)|niente panico|senza (?:feriti"
    "|indugio)",
    "Russian": "никто не (?:пострадал|ранен|погиб)|пострадавших нет|(?:это )?не (?:учения|шутка|учебная"
    "|тренировка)|без паники|без шуток|(?:жертв|раненых) нет|нет (?:пострадавших|жертв"
    "|раненых)",
    "Dutch": "(?:niemand|geen mens)(?: is| raakte)? gewond|geen (?:gewonden|slachtoffers|grap|oefening"
    "|paniek)|niet gewond|zonder (?:paniek|aarzelen)",
    "Polish": "nikt nie (?:ucierpiał|został ranny|jest ranny|zginął)|(?:nie ma|brak) (?:rannych|ofiar)"
    "|to nie (?:są )?(?:ćwiczenia|żart[y]?)|bez paniki|nikomu nic się nie stało",
}
HARM_UNSPACED: dict[str, str] = {
    "Japanese": "(?:けが人|怪我人|ケガ人|負傷者|被害者|犠牲者)[はもが]?(?:い(?:ません|ない)|なし|ゼロ"
    "|出てい?(?:ません|ない))|(?:訓練|冗談|嘘|うそ|練習|テスト)(?:では|じゃ)(?:ありません"
    "|ない|なく)|誰も(?:けが|怪我|ケガ)(?:は|を)?(?:して)?い?(?:ません|ない)|無事(?:です"
    "|だ)(?:が|けど)",
    "Chinese": "(?:没有?人?|无人?|沒有人?)(?:员)?(?:受伤|伤亡|受傷)|(?:不是|并非)(?:演习|开玩笑|训练"
    "|玩笑)|别慌|不要(?:慌|惊慌)",
    "Korean": "다친 (?:사람|분)[은는이]? ?없|(?:부상자|사상자|인명 ?피해)[은는가]? ?없|(?:훈련|농담"
    "|장난)이? ?아(?:니|닙)",
}
"""Denials of harm, of a joke or of a drill: they say nothing against a fire."""

DOUBT: dict[str, str] = {
    "English": "(?:don't|do not|dont|doesn't|does not|didn't) (?:think|believe|look like|seem|assume"
    "|trust)|doubt|unlikely",
    "French": "(?:ne |n')?(?:pense|crois) pas que",
    "Spanish": "no (?:creo|pienso|parece) que",
    "Portuguese": "não (?:acho|creio|parece) que",
    "Italian": "non (?:credo|penso|sembra) che",
    "Dutch": "(?:denk|geloof) niet dat",
}
"""Denials of what follows, also of an end: "I don't think it has stopped"."""

LASTING: dict[str, str] = {
    "English": "still|continues|keeps|again|not over|ongoing|raging|getting|growing|spreading|bigger|worse",
    "German": "noch|immer noch|weiterhin|wieder",
    "French": "toujours|encore|continue",
    "Spanish": "sigue|siguen|todavía|aún|continúa",
    "Portuguese": "ainda|continua|continuam",
    "Italian": "ancora|continua",
    "Russian": "ещё|еще|по-прежнему|продолжа[а-я]*|снова",
    "Dutch": "nog|steeds|weer",
    "Polish": "wciąż|nadal|jeszcze|znowu|dalej",
}
LASTING_UNSPACED: dict[str, str] = {
    "Japanese": "まだ|今も|依然|再び",
    "Chinese": "还在|仍|依然|又",
    "Korean": "아직|여전히|계속",
}
"""What says that a fire goes on: the end of another one takes nothing back."""

MISTAKEN: dict[str, str] = {
    "English": "(?:only|just|merely|nothing but|simply) (?:a |an |the |some "
    "|my ){0,3}(?:[a-z]+ )?(?:steam|fog|mist|dust|rumou?r|barbecue|bbq|sunset|test|drill|joke"
    "|reflection|neon|red light|lamp|heater|exercise|cooking|toast)"
    "|turned out to be (?:nothing|a false|steam|fog|a joke|a rumou?r|false)",
    "German": "nur (?:ein |eine |der |die |das )?(?:wasser)?(?:dampf|nebel|scherz|übung|test|gerücht|staub|grill)",
    "French": "(?:juste|seulement|que|simple) (?:de la |du |un |une )?(?:vapeur|brume|brouillard|blague"
    "|exercice|rumeur|poussière)",
    "Spanish": "(?:solo|sólo) (?:era |es |fue )?(?:un |una |el )?(?:vapor|niebla|rumor|broma|simulacro|polvo)",
    "Portuguese": "(?:só|apenas) (?:era |é |foi )?(?:um |uma |o )?(?:vapor|neblina|boato|brincadeira|simulado|poeira)",
    "Italian": "(?:solo|soltanto) (?:del |un |uno |una )?(?:vapore|nebbia|scherzo|esercitazione|polvere)",
    "Russian": "(?:просто|всего лишь|только|лишь) (?:пар|туман|шутка|учения|пыль|слух)",
    "Dutch": "(?:maar|slechts|alleen|gewoon) (?:een )?(?:stoom|mist|grap|oefening|gerucht|stof)",
    "Polish": "(?:tylko|jedynie) (?:para|mgła|żart|ćwiczenia|plotka|kurz)",
}
MISTAKEN_UNSPACED: dict[str, str] = {
    "Japanese": "(?:ただの|単なる)(?:湯気|霧|冗談|訓練|噂|埃)|湯気(?:でした|だった|です)|霧(?:でした"
    "|だった)|勘違い|見間違|気のせい|冗談でした|デマ",
    "Chinese": "只是(?:蒸汽|水蒸气|雾|演习|玩笑|谣言)|虚惊|看错了",
    "Korean": "수증기|김이(?:었|에)|안개(?:였|예)|착각|장난이었",
}
"""What says that it was something else; a denial beside it does not make it a fire."""
