"""The English and Japanese words that `warning_rule` looks for.

Every pattern is a regular expression: a list of alternatives. English patterns match only whole words. Japanese
patterns match anywhere in a text; their names end in `JAPANESE`. All words are in lower case.
"""

FIRE = (
    "fires?|wildfires?|flames?|blazes?|blazing|ablaze|inferno|burn|burns|burned|burnt|burning"
    "|smoke|smoky|smou?ldering|evacuat(?:e|es|ed|ing|ion|ions)|alight|aflame|conflagration"
    "|engulfed in|smokes|smoking (?:ruins?|wreck|rubble)"
)
FIRE_JAPANESE = (
    "火事|火災|[着失起大]火|火の手|火元|火の粉|(?<!噴)出火|発火|延焼|消火|燃え|燃焼|焦げ臭|炎上"
    "|(?<![肺脳胃腸])炎(?![症天])|(?<![禁喫])煙(?!草)|避難|(?<![花聖灯])火(?=[がはも]"
    "|を[見確発感]|から|に近)|焦げ(?=[たて臭く]|る?(?:臭|にお|匂))|きな臭|くすぶ|火の海"
    "|ぼや(?:騒ぎ|が|です)|ボヤ|小火|(?<!日)(?<!夕)(?<!胸)焼け(?=て|落ち)|燃や|黒煙|白煙"
)
"""Words that mention a fire, smoke, flames or an evacuation."""

PICTURED = "🔥 {0,3}(?:at|in|near|by|on|@)(?![a-z])"
"""The fire emoji, if a place follows ("🔥 at the bar"). Without a place, the emoji often means praise, not a fire."""

FLEE = (
    "(?<!to )(?<!i )(?<!we )(?<!will )(?<!'ll )(?<!must )(?<!should )(?<!can )(?<!could )(?<!let's )(?:leave"
    "|clear|vacate|exit) (?:the [a-z]+|it|here|there|this place|that place"
    "|your [a-z]+) (?:now|immediately|at once|right away|right now|this instant|quickly|asap)"
    "|(?<!to )(?<!i )(?<!we )(?<!will )(?:leave|get out|get away) (?:immediately|at once"
    "|right now|asap)|get out(?: now|!+ )(?!of my)|get out of (?:the [a-z]+|there"
    "|here) (?:now|immediately|at once|right now|fast|quickly|asap)|run for (?:your"
    "|ur) (?:life|lives)|(?:everyone|everybody)(?: must| needs to| has to| should| please"
    "|,)? (?:(?:get )?out(?! (?:and|with|for|tonight|here))|leave(?: the [a-z]+"
    "| here)? (?:now|immediately|at once))|save yoursel(?:f|ves)"
)
FLEE_JAPANESE = (
    "(?:今すぐ|すぐに?|直ちに|ただちに|至急)[^。!?、]{0,12}(?:出て|逃げて|離れて|脱出して"
    "|退避して)(?:くだ|下さ|!|。|$)|逃げろ|逃げて(?:ください|!|。|$)"
)
"""Calls to get away that are so urgent that they count as a warning even if they name no fire."""

SHUN = (
    "(?<!'ll )(?<!will )(?<!to )avoid|(?:stay|keep|steer|get) (?:well )?(?:away|clear|out"
    "|off)|stay back from|(?:do not|don't|dont|never) (?:go|come|walk|step|move|enter|cross"
    "|pass|approach|stand|stay|linger)(?! from)"
)
"""Words that tell others to avoid the position that follows ("stay away from")."""

HAZARD = (
    "(?:hazards?|hazardous|danger|dangers|dangerous|deadly|lethal)(?! of)|(?:not"
    "|n't)(?: at all| really| very)? safe|unsafe|too hot to|emergency|(?:lost|losing|lose"
    "|took|taking|take)(?: [a-z]+){0,3} (?:health|hp|life|lives|damage)|(?:it|that|this|spot"
    "|cell|place|area|heat) (?:hurts|kills)|killed|scorching|unbearably hot|life-threatening"
    "|death trap|deathtrap"
)
HAZARD_JAPANESE = "危険|危ない|非常事態|緊急事態|緊急です|命に関わ|安全では(?:ない|ありません)|熱すぎ|ダメージ|致命"
"""Words for danger. These words count as a mention of a fire only beside a position or a call to get away."""

ESCAPE = (
    "run(?! (?:into|out of|by|for the bus|a|the|low))|flee|fleeing|get (?:out|away|back)"
    "|(?:everyone|everybody|all of you|all) out|out of (?:there|here)|get everyone out"
    "|(?:leave|clear|vacate|exit) (?:the [a-z]+ |it |here |there |now|immediately|at once"
    "|everyone)|stay (?:away|clear|back|out)|keep (?:away|out|clear|back|your distance"
    "|a distance|at least|off|everyone)|avoid|escape|turn (?:around|back)|go around"
    "|steer clear|back off|head (?:away|elsewhere)|move away|do not (?:go|come|enter|walk"
    "|stay|approach|pass|cross|stand)|(?:don't|dont) (?:go|come|enter|walk|stay|approach|pass"
    "|cross|stand)|never (?:go|enter)|(?:save|protect) yourself|take cover"
)
ESCAPE_JAPANESE = (
    "逃げ|離れて|離れろ|近づかない|近づくな|近寄らない|近寄るな|行かない(?:で|ほう|方)|行くな"
    "|入らない|避けて|避けろ|脱出|退避|立ち去|迂回|外へ出て|外に出て"
)
"""Words that call others to get away or to stay away."""

OTHER_SENSE = (
    "fire (?:drills?|exercises?|stations?|trucks?|engines?|extinguishers?|safety|exits?"
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
    "|absolutely|literally|just|so|truly)){0,3} on fire"
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
    "|negative|n/a)(?= *(?:$|[,.;})!]))"
)
OTHER_SENSE_JAPANESE = (
    "消火器|火を通|火にかけ|火の車|火がつく|やる気に燃え|情熱に燃え|燃え(?:る想い|尽き症候群"
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
    "|って)?[^。、]{0,4}燃え[^。、!?]{0,4}"
)
"""Expressions in which words for fire have another sense."""


NOT = (
    "zero|no(?! (?:doubt|time|matter))"
    "|not(?! (?:only|just|far|sure))|[a-z]+n't(?! (?:know|only|just))|cannot|cant|dont|never"
    "|without|neither|nor|none|nobody|nothing|free of|free from|absence of"
)
NOT_JAPANESE = (
    "ません|(?<!危)(?<!違い)(?<!か)ない(?![でかほ方よ])|なかった|なく(?!て)|[無未]|なし|(?:見え|確認でき|起き)ず"
)
"""Denials."""

GO = (
    "go|going|come|return|approach|enter|stay|staying|remain|get|getting|walk|move|head|visit"
    "|wait|linger|use|cross|pass|touch|ignore|forget|underestimate|escape|reach|breathe"
    "|be (?:near|close)|want to be|put|control|stop|extinguish|safe"
)
"""Actions after "do not" or "cannot": "do not touch the fire" denies the action, not the fire, so it is a warning."""

FORBIDDEN_JAPANESE = (
    "ないで|ない(?:ほう|方|よう)|かもしれ(?:ない|ません)|知れません|しかありません|危ない"
    "|(?:安全|大丈夫)(?:な[^。]{0,4})?(?:では?|じゃ)(?:ない|ありません)|(?:では?|じゃ)ないか"
)
"""Japanese denials that do not deny a fire: they forbid an action or say "maybe" ("かもしれない")."""

OVER = (
    "(?:is|are|was|'s|been|went|gone|burn(?:ed|t)|died)(?: (?:now|already|finally|all"
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
    "|completely out|hoax|prank|just kidding|was (?:kidding|joking|a joke)|only a joke"
)
OVER_JAPANESE = (
    "消え|鎮火|消火(?:され|しま|した|済|でき)|消し止め|消しました|消した|収ま|おさま|もう(?:安全|大丈夫)|誤報|治ま|解除"
)
"""Words that say that a fire is over, or that there never was one."""

UNTIL = "until|till|before|trying to|to be"
UNTIL_JAPANESE = "まだ"
"""Words that say that the end of a fire is still to come, such as "until"."""

PAST = (
    "yesterday|last (?:night|week|month|year|summer|winter)|(?:days|weeks|months|years) ago"
    "|used to|once upon|(?:was|were) (?:fighting|rebuilt)|long ago|ages ago|back in|back when"
    "|as a (?:child|kid|boy|girl)|when i was|in (?:18|19|20)[0-9][0-9]|the other (?:day|week)"
    "|(?:a|one|two|three) (?:day|week|month|year)s? ago|last (?:spring|autumn|fall|january"
    "|february|march|april|may|june|july|august|september|october|november|december|monday"
    "|tuesday|wednesday|thursday|friday|saturday|sunday)|once (?:burn[a-z]*|had)|years back"
    "|centur(?:y|ies)|decades?"
)
PAST_JAPANESE = (
    "昨日|先週|先月|昨年|去年|昔|以前|先日|一昨日|おととい|昨夜|昨晩|かつて|年(?:も|ほど)?前"
    "|(?:か|ヶ)月前|週間前|日前|子供の(?:頃|ころ)|当時|前年|古代"
)
"""Words for the past, such as "yesterday"; a fire of the past is no warning."""

SUPPOSED = (
    "if(?! you (?:are|want|can))|whether|in case|in the event|unless|imagine|suppose|books?"
    "|novel|films?|movie|story|stories|history|documentary|dream(?:ed|t)?|poem|great fire of"
    "|(?:any|some) news|reports? of any|hypothetical(?:ly)?|in general|generally|in theory"
    "|fires? (?:can|could|may|might) (?:be|spread|start)|what if|chapters?|paintings?"
    "|legends?|myths?|tales?|lyrics|scenes?|dragons?|episodes?|(?:in|of) (?:my|the|this|a"
    "|that|our) (?:game|show|play|quest)|opera|anime|manga|podcasts?|practice|rehearsal"
    "|simulation|drills?|video ?game|board game|should (?:a|any|there)|were to|thriller|comic"
    "|trailer|rules? (?:for|say)|safety tips?|training"
)
SUPPOSED_JAPANESE = (
    "もし|(?:あっ|起き|見かけ|見つけ|発生し|見)たら|場合|かどうか|映画|小説|物語|訓練|歴史"
    "|博物館の|夢|(?:だ|か)と思った(?:ら|けど|が)|万が一|万一|仮に|いざという|漫画|アニメ"
    "|ゲーム|ドラマ|ドラゴン|一般に|一般的に|(?:起き|あっ|出)た(?:とき|時)"
)
"""Words before a mention that make it a supposition ("if"), an indirect question ("whether") or a tale ("a book")."""

HARM = (
    "no (?:casualties|injuries|victims|deaths|panic|joke|drill|exaggeration|kidding|lie|cap"
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
    "|us|anyone)"
)
HARM_JAPANESE = (
    "(?:けが人|怪我人|ケガ人|負傷者|被害者|犠牲者)[はもが]?(?:い(?:ません|ない)|なし|ゼロ"
    "|出てい?(?:ません|ない))|(?:訓練|冗談|嘘|うそ|練習|テスト)(?:では|じゃ)(?:ありません"
    "|ない|なく)|誰も(?:けが|怪我|ケガ)(?:は|を)?(?:して)?い?(?:ません|ない)|無事(?:です"
    "|だ)(?:が|けど)"
)
"""Denials of harm, of a joke or of a drill, which do not deny a fire."""

DOUBT = "(?:don't|do not|dont|doesn't|does not|didn't) (?:think|believe|look like|seem|assume|trust)|doubt|unlikely"
"""Words that deny the words after them, even the end of a fire: "I don't think it has stopped"."""

LASTING = "still|continues|keeps|again|not over|ongoing|raging|getting|growing|spreading|bigger|worse"
LASTING_JAPANESE = "まだ|今も|依然|再び"
"""Words that say that a fire continues. "fire2 still burns, fire1 is out" is a warning because of the word "still"."""

MISTAKEN = (
    "(?:only|just|merely|nothing but|simply) (?:a |an |the |some "
    "|my ){0,3}(?:[a-z]+ )?(?:steam|fog|mist|dust|rumou?r|barbecue|bbq|sunset|test|drill|joke"
    "|reflection|neon|red light|lamp|heater|exercise|cooking|toast)"
    "|turned out to be (?:nothing|a false|steam|fog|a joke|a rumou?r|false)"
)
MISTAKEN_JAPANESE = (
    "(?:ただの|単なる)(?:湯気|霧|冗談|訓練|噂|埃)|湯気(?:でした|だった|です)|霧(?:でした"
    "|だった)|勘違い|見間違|気のせい|冗談でした|デマ"
)
"""Words that say that a supposed fire was something else ("only steam"), even beside a denial."""


STATED = (
    "there|here|i|i'm|i've|we|we're|it|it's|that|this|the|a|an|my|our|he|she|they|agent|watch|beware|careful|warning|be"
)
"""Words with which a statement can begin before a question in the same sentence: "there is a fire, shall we go?"."""

ASKED_JAPANESE = "(?<!ません)(?<!ない)(?<!でしょ)か$|(?<!ない)でしょうか$|かな$"
"""Ends of sentences that are questions in Japanese even without a question mark, such as "か"."""

FACTIVE = (
    "(?:did|do|have|has|had|can|could|don't|didn't|haven't|hasn't|can't) (?:you|u|ya|y'all"
    "|anyone|anybody|everyone|everybody|any of you)(?: guys| all| folks| even| not"
    "| also){0,3} (?:know|notice[d]?|see|saw|seen|hear|heard|reali[sz]e[d]?|believe|smell"
    "|aware|tell|feel)(?: yet| already)?(?: about)? (?:that|the (?!news)|this|how|our|my|its"
    "|these|those|there's|there is|it's)(?! (?:book|film|movie|song|game|novel|fire is out))"
    "|(?:can|could|would) (?:you|u|anyone) (?:even )?believe|(?:did|have|do) (?:you|u|ya"
    "|y'all|anyone)(?: guys| all| not){0,3} (?:notice[d]?|reali[sz]e[d]?|know)(?! (?:if"
    "|whether|any|where|what|who|of any|about any|about|how|when|some|somebody|anything"
    r"|of)\b)|(?:are|is) (?:you|u|everyone|anyone|everybody)(?: all)? aware(?: that| of)?"
    "|you(?: do| all)? (?:know|reali[sz]e|see|noticed|saw) (?:that )?(?=the |it's |there's )"
    "|(?:can|could|would|will) (?:you|u|everyone|everybody|anyone|all|all of you"
    "|people)(?: (?:near|in|at|by|inside|around) (?:the )?[a-z]+)?(?: all"
    "| just)? (?:please )?(?=leave|get|move|avoid|stay|keep|come away|run|evacuate|not|steer"
    "|clear|spread the|pass|warn)|(?:should|shall|could)(?:n't)? (?:we|you|i|everyone)(?: not"
    "| all)? (?=leave|run|flee|avoid|get (?:out|away)|stay away|evacuate|go around)|why (?:is"
    "|are|isn't|aren't|did)(?: you| u| nobody| no one| anyone| everyone| people| they| we"
    "| agent)?(?: still| not)?|what are (?:you|they) (?:still )?doing|how come"
    "|who else (?:can see|sees|saw|smells|noticed|heard about)|haven't (?:you|u) heard"
    "|isn't it (?:terrible|awful|scary|crazy|horrible)(?: that| how)?|(?:has|have"
    "|did) (?:anyone|anybody|everyone|you) (?:else )(?:also )?(?:noticed?|seen?|hear|heard"
    "|smell|smelled|smelt)"
)
"""First words of questions that treat their content as a fact: "did you notice that the bar burns?"."""

FACTIVE_JAPANESE = (
    "(?:(?:の|こと)[はをにが]?|って|と)、?(?:もう|みんな|皆さん)?(?:見え(?:ま|る|た)|見ま"
    r"|見た|見て|気づ|気付|知って|知らな|ご存|聞き|聞いた|わかり)[^?。]{0,10}\?"
)
"""Words at the end of a Japanese question that treats its content as a fact."""

LINKS = "but|and|so|because|since|while|although|though|however|as|then|due to"
LINKS_JAPANESE = "(?<=[すただい])(?:が|けれども?|けど|ので|から|ため|し)"
"""Words at which the text is split into clauses."""
