"""The basic words of Japanese and Chinese, which are written without blanks."""

from __future__ import annotations

from foundry.worlds.usd.language.words import Act, Dimension, Kind, Side, Table, Way, Word, numbers, phrases


def _inflected(word: Word, stems: str, endings: str) -> dict[str, Word]:
    """Return a table of every stem with every ending; both separated by blanks, `-` being no ending."""
    return {stem + ending.replace("-", ""): word for stem in stems.split() for ending in endings.split()}


def _before(act: Act, *ways: Way) -> Word:
    return Word(Kind.VERB, act=act, side=Side.BEFORE, ways=ways, goes=True)


_GODAN = {
    "む": "む み みます もう みたい んで",
    "る": "る り ります ろう りたい って",
    "く": "く き きます こう きたい いて",
}
_SURU = "- する します しよう したい して せよ しろ"
_NEGATED = "しない しません せず しないで"

_JAPANESE_VERBS: Table = {
    **_inflected(_before(Act.MOVE), "進", _GODAN["む"]),
    **_inflected(_before(Act.MOVE), "下が", _GODAN["る"]),
    **_inflected(_before(Act.MOVE), "歩 動", _GODAN["く"]),
    **_inflected(_before(Act.MOVE), "移動", _SURU),
    **_inflected(_before(Act.MOVE, Way.FORWARD), "前進 直進", _SURU),
    **_inflected(_before(Act.MOVE, Way.BACK), "後退", _SURU),
    **_inflected(_before(Act.MOVE, Way.BACK), "後ろに下が 後ろへ下が うしろに下が 後ずさ", _GODAN["る"]),
    **_inflected(_before(Act.TURN), "回転 旋回", _SURU),
    **_inflected(_before(Act.TURN), "曲が 回", _GODAN["る"]),
    **_inflected(_before(Act.TURN), "向け", "る ます よう たい"),
    **_inflected(_before(Act.TURN), "向", "く きます こう きたい"),
    **_inflected(_before(Act.TURN, Way.RIGHT), "右折 右回転 右旋回", _SURU),
    **_inflected(_before(Act.TURN, Way.LEFT), "左折 左回転 左旋回", _SURU),
    **_inflected(
        Word(Kind.VERB, act=Act.TURN, side=Side.BEFORE, ways=(Way.AROUND,), number=180.0),
        "振り返 後ろを振り返",
        _GODAN["る"],
    ),
    **_inflected(
        Word(Kind.VERB, act=Act.TURN, side=Side.BEFORE, ways=(Way.AROUND,), number=180.0),
        "後ろを向 うしろを向 反対を向 反対方向を向",
        "く きます こう きたい",
    ),
    **_inflected(_before(Act.LOOK), "見", "る ます よう たい"),
    **_inflected(_before(Act.LOOK, Way.UP), "見上げ", "る ます よう たい"),
    **_inflected(_before(Act.LOOK, Way.DOWN), "見下ろ", "す します そう したい"),
}

JAPANESE: Table = {
    **_JAPANESE_VERBS,
    **_inflected(Word(Kind.WAY, ways=(Way.FORWARD,)), "前 まえ 正面", "に へ 方向に 方に の方に"),
    **phrases(Word(Kind.WAY, ways=(Way.FORWARD,)), "前方に | 前方へ | まっすぐ | 真っ直ぐ | まっすぐに | 真っすぐ"),
    **_inflected(Word(Kind.WAY, ways=(Way.BACK,)), "後ろ うしろ 後方", "に へ 方向に の方に"),
    **_inflected(Word(Kind.WAY, ways=(Way.LEFT,)), "左", "に へ を 方向に 方向へ の方に の方を 側に 向きに"),
    **_inflected(Word(Kind.WAY, ways=(Way.RIGHT,)), "右", "に へ を 方向に 方向へ の方に の方を 側に 向きに"),
    **phrases(Word(Kind.WAY, ways=(Way.LEFT,)), "反時計回りに | 反時計回り | 反時計方向に"),
    **phrases(Word(Kind.WAY, ways=(Way.RIGHT,)), "時計回りに | 時計回り | 時計方向に"),
    **_inflected(Word(Kind.WAY, ways=(Way.FORWARD, Way.LEFT)), "左前 左前方 左斜め前 斜め左前", "に へ 方に"),
    **_inflected(Word(Kind.WAY, ways=(Way.FORWARD, Way.RIGHT)), "右前 右前方 右斜め前 斜め右前", "に へ 方に"),
    **_inflected(Word(Kind.WAY, ways=(Way.BACK, Way.LEFT)), "左後ろ 左斜め後ろ 斜め左後ろ", "に へ 方に"),
    **_inflected(Word(Kind.WAY, ways=(Way.BACK, Way.RIGHT)), "右後ろ 右斜め後ろ 斜め右後ろ", "に へ 方に"),
    **_inflected(Word(Kind.WAY, ways=(Way.UP,)), "上", "に へ を 方向に 方向を の方を 向きに"),
    **_inflected(Word(Kind.WAY, ways=(Way.DOWN,)), "下", "に へ を 方向に 方向を の方を 向きに"),
    **phrases(Word(Kind.NOT, reach="before"), "しない | しません | せず | しないで"),
    **_inflected(Word(Kind.VERB, act=Act.MOVE, side=Side.BEFORE, negated=True), "前進 後退 移動 直進", _NEGATED),
    **_inflected(Word(Kind.VERB, act=Act.TURN, side=Side.BEFORE, negated=True), "回転 旋回", _NEGATED),
    **_inflected(
        Word(Kind.VERB, act=Act.MOVE, side=Side.BEFORE, negated=True), "進ま 下がら 歩か", "ない ず ないで ずに"
    ),
    **_inflected(Word(Kind.VERB, act=Act.MOVE, side=Side.BEFORE, negated=True), "進み 下がり 歩き", "ません ませんで"),
    **_inflected(
        Word(Kind.VERB, act=Act.TURN, side=Side.BEFORE, negated=True), "向か 曲がら 回ら", "ない ず ないで ずに"
    ),
    **_inflected(Word(Kind.STAY), "動か", "ない ず"),
    **_inflected(Word(Kind.STAY), "動き", "ません"),
    **_inflected(Word(Kind.STAY), "とどま 留ま 止ま", "る ります"),
    **_inflected(Word(Kind.STAY), "停止 待機 静止", "- する します"),
    **phrases(Word(Kind.STAY), "何もしない | 何もしません | 待つ | 待ちます | そのまま"),
    **phrases(Word(Kind.PLACE), "その場に | その場で | ここに | ここで | 現在の位置に | 現在位置に"),
    **phrases(Word(Kind.SMALL), "少し | すこし | ちょっと | 少しだけ | わずかに"),
    **phrases(
        Word(Kind.FILLER), "に | へ | を | だけ | ほど | くらい | ぐらい | 約 | およそ | さらに | もう | 体を | 分"
    ),
    **phrases(Word(Kind.GAZE), "視線を | 顔を | カメラを | 頭を | 目線を"),
    **phrases(Word(Kind.JOIN), "その後 | それから | 次に | そして | してから"),
    **phrases(Word(Kind.OR), "または | もしくは | あるいは"),
    **phrases(Word(Kind.POSSIBLE, reach="before"), "こと"),
    **phrases(Word(Kind.FILLER), "ことにします | ことにする"),
    **phrases(Word(Kind.CONDITION), "もし"),
    **phrases(Word(Kind.EXAMPLE), "例: | 例えば | たとえば | 例として"),
    **phrases(
        Word(Kind.UNKNOWN),
        "向いている | 向いています | 向いて | 見るため | 進むため | 進むと | 回転すると | 回転すれば",
    ),
    **phrases(Word(Kind.UNIT, dimension=Dimension.LENGTH, number=1.0), "メートル | メーター | 米"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.01), "センチメートル | センチ | 厘米 | 公分"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.001), "ミリメートル | ミリ | 毫米"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.LENGTH, number=1000.0), "キロメートル | キロ | 公里"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.3048), "フィート | 英尺"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.0254), "インチ | 英寸"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.STEP, number=1.0), "歩 | 步"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.ANGLE, number=1.0), "度"),
    **phrases(Word(Kind.UNIT, dimension=Dimension.OTHER), "秒 | 回 | 次"),
    **numbers("〇=0 一=1 二=2 三=3 四=4 五=5 六=6 七=7 八=8 九=9 两=2 半=0.5"),
    **numbers("十=10 百=100", scale=True),
}

_BOTH = Side.BOTH

CHINESE: Table = {
    **phrases(Word(Kind.VERB, act=Act.MOVE, side=_BOTH, goes=True), "走 | 移动 | 行走 | 移動 | 走动"),
    **phrases(Word(Kind.VERB, act=Act.MOVE, side=_BOTH, ways=(Way.FORWARD,)), "前进 | 前進 | 直走"),
    **phrases(Word(Kind.VERB, act=Act.MOVE, side=_BOTH, ways=(Way.BACK,)), "后退 | 後退 | 倒退"),
    **phrases(Word(Kind.VERB, act=Act.TURN, side=_BOTH), "转 | 旋转 | 转动 | 轉 | 旋轉"),
    **phrases(Word(Kind.VERB, act=Act.TURN, side=_BOTH, ways=(Way.LEFT,)), "左转 | 向左转 | 左轉 | 向左轉"),
    **phrases(Word(Kind.VERB, act=Act.TURN, side=_BOTH, ways=(Way.RIGHT,)), "右转 | 向右转 | 右轉 | 向右轉"),
    **phrases(
        Word(Kind.VERB, act=Act.TURN, side=_BOTH, ways=(Way.AROUND,), number=180.0), "转身 | 掉头 | 向后转 | 轉身"
    ),
    **phrases(Word(Kind.VERB, act=Act.LOOK, side=_BOTH), "看"),
    **phrases(Word(Kind.VERB, act=Act.LOOK, side=_BOTH, ways=(Way.UP,)), "抬头 | 抬頭 | 仰视"),
    **phrases(Word(Kind.VERB, act=Act.LOOK, side=_BOTH, ways=(Way.DOWN,)), "低头 | 低頭 | 俯视"),
    **phrases(Word(Kind.WAY, ways=(Way.FORWARD,)), "向前 | 往前 | 向前方 | 朝前"),
    **phrases(Word(Kind.WAY, ways=(Way.BACK,)), "向后 | 往后 | 向後 | 朝后"),
    **phrases(Word(Kind.WAY, ways=(Way.LEFT,)), "向左 | 往左 | 朝左 | 逆时针"),
    **phrases(Word(Kind.WAY, ways=(Way.RIGHT,)), "向右 | 往右 | 朝右 | 顺时针"),
    **phrases(Word(Kind.WAY, ways=(Way.UP,)), "向上 | 往上 | 朝上"),
    **phrases(Word(Kind.WAY, ways=(Way.DOWN,)), "向下 | 往下 | 朝下"),
    **phrases(Word(Kind.STAY), "原地不动 | 保持不动 | 停留 | 停留在原地 | 不动 | 留在原地 | 待在原地"),
    **phrases(Word(Kind.NOT), "不要 | 不 | 别 | 勿 | 不能 | 无需 | 不需要"),
    **phrases(Word(Kind.POSSIBLE), "可以 | 可能"),
    **phrases(Word(Kind.CONDITION), "如果 | 因为"),
    **phrases(Word(Kind.JOIN), "然后 | 然後 | 并 | 再 | 而是"),
    **phrases(Word(Kind.OR), "或 | 或者"),
    **phrases(Word(Kind.SMALL), "一点 | 一下 | 稍微 | 一點"),
    **phrases(Word(Kind.FRESH), "我 | 我会 | 我将"),
}
