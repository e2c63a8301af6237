"""The words by which `sight_rule` reads a reply: names of things, and cues such as "see" or "looking for"."""

THINGS: dict[str, str] = {
    "logo": "logos?|logotype|emblems?|insignia|ロゴ(?:マーク)?|エンブレム",
    "fire extinguisher": "(?:fire )?extinguishers?|消火器",
    "water cooler": "water ?(?:coolers?|dispensers?)|ウォーターサーバー|ウォータークーラー",
    "printer": "printers?|copiers?|photocopiers?|プリンター?|コピー機|複合機",
    "whiteboard": "white ?boards?|ホワイトボード|白板",
    "refrigerator": "refrigerators?|fridges?|冷蔵庫",
    "coffee machine": "coffee ?(?:machines?|makers?)|espresso machines?|コーヒー(?:マシン|メーカー)",
    "sofa": "sofas?|couch(?:es)?|settees?|ソファー?",
    "globe": "globes?|地球儀",
    "safe": "safes?|strongbox|金庫",
    "picture": "pictures?|paintings?|artworks?|絵画?|絵|作品|画",
    "door": "doors?|doorway|ドア|扉|門",
    "table": "tables?|desks?|テーブル|机",
    "chair": "chairs?|椅子|いす",
    "plant": "plants?|植物",
    "window": "windows?|窓",
    "lamp": "lamps?|ceiling lights?|light fixtures?|照明|ランプ",
    "wall": "walls?|壁(?!紙)",
    "sign": "signs?|signage|placards?|案内板|標識|看板",
    "cabinet": "cabinets?|cupboards?|キャビネット|戸棚",
    "notice board": "(?:notice|bulletin|cork|pin) ?boards?|掲示板",
    "sculpture": "sculptures?|statues?|彫刻|彫像",
    "hatch": "hatch(?:es)?|ハッチ",
    "rack": "racks?|ラック",
    "laptop": "laptops?|notebook computers?|ノート(?:パソコン|pc)",
    "handrail": "hand ?rails?|grab bars?|手すり",
    "airlock": "air ?locks?|エアロック",
    "bag": "bags?|stowage bags?|バッグ|袋",
    "glovebox": "glove ?box(?:es)?|グローブボックス",
    "free flyer": "free[ -]?flyers?|flying robots?|フリーフライヤー",
    "person": "persons?|people|m[ae]n|wom[ae]n|humans?|astronauts?|人物|人間|人影|宇宙飛行士",
    "screen": "screens?|monitors?|televisions?|モニター?|スクリーン",
    "shelf": "shel(?:f|ves)|bookcases?|bookshel(?:f|ves)|棚(?!卸)|本棚",
    "box": "box(?:es)?|crates?|cartons?|(?<!険)箱(?!根)",
    "bed": "beds?|ベッド",
    "clock": "clocks?|時計",
    "trash can": "(?:trash|garbage|waste) ?(?:cans?|bins?|baskets?)|ゴミ箱",
    "stairs": "stairs?|staircases?|stairways?|階段",
}
"""For each thing, by its English name, a pattern of all its names; English names match whole words only.

To find the kind of a labelled thing, foundry looks up the last words of its label, such as `logo` in `JAXA logo`.
"""

AMBIGUOUS = ("safe", "picture", "box", "bag", "screen")
"""Names of things that also have other meanings ("it is safe"); a name counts only if its thing is in the scene."""

THE_TARGET = "(?:the|my|our) (?:target|goal object|target object)|ターゲット|目標物?|対象物?"
"""Expressions that mean the target of any walk."""

ARTICLES = "the|this|that"
"""After one of these words, the last word of a name stands for the whole name: `the logo` means `JAXA logo`."""

NOT = (
    r"no|not|[a-z]+n't|cannot|cant|dont|never|without|neither|nor|none|nowhere|unable|fail(?:ed|s)? to"
    r"|nothing|hidden|obscured|blocked|occluded|out of (?:view|sight)|outside (?:of )?(?:my|the) view|absent|missing"
    r"|lost|yet to|invisible|hard to|instead of"
)
NOT_JAPANESE = (
    "見え(?:ません|ない|ず|なく|ておらず)|見当たら|見つから|見つけられ|見つけて(?:いない|おらず)|ありません"
    "|確認でき(?:ません|ない|ず|てい)|映って(?:いない|いません|おらず)|写って(?:いない|いません|おらず)"
    "|見て(?:いない|いません)|無い|なし|無く|なく|ない"
)
"""Words that say that a thing is not seen, such as "not" and "hidden"."""

UNSURE = (
    "if|whether|might|may|could|would|should|must|maybe|perhaps|possibly|probably|likely|presumably|until"
    "|unless|hope(?:fully)?|hoping|expect(?:ed|ing)?|assum(?:e|ing)|so that|in case|where is|know where|once|when"
    "|usually|typically|will (?:[a-z]+ )?(?:see|find|be|come)|earlier|previously|imagin(?:e|ing)|guess"
)
UNSURE_JAPANESE = (
    "(?:見え|あ)(?:る|ます)?(?:と思|はず|可能性|かも|か(?=どうか|を|確)|でしょう|だろう|よう|まで"
    "|れば|たら)|かもしれ|だろう|でしょう|はず|可能性|思われ"
)
"""Words for a guess, a wish, a condition or a memory, such as "maybe"; they cancel a claim to see a thing."""

SEARCHED = (
    "look(?:ing|s|ed)?(?: around)? for|search[a-z]*|find|finding|locate|locating|seek(?:ing)?"
    "|scan(?:ning)?(?: [a-z]+){0,3} for|hunt(?:ing)?"
    "|(?:to|better) (?:see|spot|identify|notice|detect|recogni[sz]e|view)"
    "|need(?:s|ed)?|want|try|trying|aim(?:ing)? (?:to|at|for)"
)
SEARCHED_JAPANESE = (
    "探|捜|見つける|見つけたい|見つけよう|見つけ出|発見する|発見したい|確認する|確認したい|見たい|見るため"
)
"""Words that say that a thing is still to be found, such as "looking for"."""

HEADED_FOR = (
    "towards?|approach(?:ing)?|closer to|nearer to|reach|(?:get|getting|go|going|move|moving|path|way|leads?"
    "|leading|points?|pointing|distance|directions?) to"
)
HEADED_FOR_JAPANESE = "近づ|近寄|向か|接近|目指"
"""Words that say that an agent is going to a thing, such as "towards"."""

SEEN = (
    "able to (?:see|spot)|see|sees|seen|seeing|spot|spots|spotted|notice[sd]?|observe[sd]?|recogni[sz]e[sd]?"
    "|identif(?:y|ied)|found|detect(?:ed)?|located|visible|in (?:my |clear |plain |full )?(?:view|sight)"
    "|(?:there|here|this|that|it)(?:'s| is| are)|shows?|showing|displays?|displaying|features?|contains?|reached"
    "|arrived at|facing|looking (?:directly |straight )?at|(?:i am|i'm) (?:[a-z]+ ){0,2}(?:at|near|next to|close to"
    "|beside|in front of)|in front of me(?: is)?|ahead(?: of me)? is"
)
SEEN_JAPANESE = (
    "見え|見つけました|見つけた|見つかりました|見つかった|発見し|確認でき|確認しました|あります|ある|映って"
    "|写って|視界に|(?:これ|それ|あれ)[はが]|到着し|見ている|見ています|見て(?:取|と)れ"
)
"""Words for seeing or reaching a thing, such as "I see" and "arrived at"."""

PLACED = (
    r"(?:is|are|'s|lies|sits|hangs|appears|stands|remains)(?: (?:clearly|partly|partially|directly|now|still|just|also"
    r"|already|right|straight|about|very|currently|fully|easily|only|well|there))* (?:visible|in (?:my |clear |plain "
    r"|full )?(?:view|sight)|in front|in the|ahead|on|at|near|nearby|right|left|there|here|above|below|behind|close"
    r"|cent(?:er|re)d|mounted|located|placed|within|next to|to (?:the|my)|directly|straight|inside|beside|against"
    r"|\d)"
)
"""Words behind the name of a thing that say that it is visible or where it is."""
