"""Chinese and Japanese words; the two languages share characters and are written without blanks."""

from dataclasses import replace

from foundry.worlds.camera.language import Act, Dimension, Form, Kind, Side, Table, Way, Word, numbers, phrases

_BOTH = Side.BOTH
_CHINESE_VERBS = (
    (Word(Kind.VERB, act=Act.MOVE, side=_BOTH, goes=True), "走 移动 行走 移動 走动 平移"),
    (Word(Kind.VERB, act=Act.MOVE, side=_BOTH, ways=(Way.FORWARD,)), "前进 前進 直走 直行 前移 前行"),
    (Word(Kind.VERB, act=Act.MOVE, side=_BOTH, ways=(Way.BACK,)), "后退 後退 倒退 退后 后移 退"),
    (Word(Kind.VERB, act=Act.MOVE, side=_BOTH, ways=(Way.LEFT,)), "左移"),
    (Word(Kind.VERB, act=Act.MOVE, side=_BOTH, ways=(Way.RIGHT,)), "右移"),
    (Word(Kind.VERB, act=Act.TURN, side=_BOTH), "转 旋转 转动 轉 旋轉 转向"),
    (Word(Kind.VERB, act=Act.TURN, side=_BOTH, ways=(Way.LEFT,)), "左转 向左转 左轉 向左轉 左拐"),
    (Word(Kind.VERB, act=Act.TURN, side=_BOTH, ways=(Way.RIGHT,)), "右转 向右转 右轉 向右轉 右拐"),
    (Word(Kind.VERB, act=Act.TURN, side=_BOTH, ways=(Way.AROUND,), number=180.0), "转身 掉头 向后转 轉身"),
    (Word(Kind.VERB, act=Act.LOOK, side=_BOTH), "看 倾斜"),
    (Word(Kind.VERB, act=Act.LOOK, side=_BOTH, ways=(Way.UP,)), "抬头 抬头看 向上抬头 抬頭 仰视 抬高 上移 抬起"),
    (Word(Kind.VERB, act=Act.LOOK, side=_BOTH, ways=(Way.DOWN,)), "低头 低头看 向下低头 低頭 俯视 降低 下移 压低 低下"),
)

_CHINESE_TOLD: Table = phrases(
    {
        Word(Kind.EARLIER): "上一步 | 上一次 | 上次 | 刚才 | 刚刚 | 之前 | 先前 | 此前 | 前一步 | 已经 | 曾 | 曾经 | "
        "在上一步 | 在上一步中 | 前几步 | 上一个动作 | 上一步动作 | 历史记录 | 我说 | 你说",
        Word(Kind.PAST): "试图 | 尝试了 | 想要 | 曾试图 | 尝试过",
        Word(Kind.NOW): "现在 | 这次 | 这一步 | 本次 | 此刻 | 目前 | 下一步动作 | 下一步行动 | 下一个动作 | "
        "下一步的动作 | 我的下一步 | 接下来",
        Word(Kind.LATER): "以后 | 稍后 | 之后再 | 下次 | 随后再 | 等会 | 待会 | 最终 | 下一次 | 然后下一步 | "
        "后面再 | 以后再",
        Word(Kind.NEXT): "下一步 | 在下一步 | 下一步再 | 在下一步中 | 下一轮",
        Word(Kind.FIRST): "但首先 | 但先 | 不过先 | 但在此之前 | 但要先 | 但我先 | 但是先 | 在此之前",
        Word(Kind.RETRACT): "不， | 不, | 不对 | 等等 | 等一下 | 更正 | 我是说 | 纠正",
        Word(Kind.OTHER): "机器人 | 人 | 宇航员 | 男人 | 女人 | 他 | 她 | 它 | 有人 | 行人 | 男子 | 女子 | 代理 | "
        "智能体 | 人员 | 他们",
        Word(Kind.PURPOSE): "为了 | 以便 | 为 | 目标是 | 任务是 | 目的是 | 我的目标是 | 我的任务是",
    }
)
"""Words for reports instead of commands: the past, other agents, purposes, postponed motions."""

CHINESE: Table = {
    **_CHINESE_TOLD,
    **{name: verb for verb, names in _CHINESE_VERBS for name in names.split()},
    **{
        f"{name}{ending}": replace(verb, form=Form.PAST)
        for verb, names in _CHINESE_VERBS
        for name in names.split()
        for ending in ("了", "过了", "过")
    },
    **phrases(
        {
            Word(Kind.WAY, ways=(Way.FORWARD,)): "向前 | 往前 | 向前方 | 朝前 | 向正前方 | 径直向前",
            Word(Kind.WAY, ways=(Way.BACK,)): "向后 | 往后 | 向後 | 朝后",
            Word(Kind.WAY, ways=(Way.LEFT,)): "向左 | 往左 | 朝左 | 逆时针 | 向左侧 | 左向",
            Word(Kind.WAY, ways=(Way.RIGHT,)): "向右 | 往右 | 朝右 | 顺时针 | 向右侧 | 右向",
            Word(Kind.WAY, ways=(Way.UP,)): "向上 | 往上 | 朝上",
            Word(Kind.WAY, ways=(Way.DOWN,)): "向下 | 往下 | 朝下",
            Word(Kind.STAY): "原地不动 | 保持不动 | 停留 | 停留在原地 | 不动 | 留在原地 | 待在原地 | 停在原地 | "
            "不移动 | 保持静止 | 静止不动 | 留在这里 | 停下 | 停止 | 原地等待 | 保持原位 | 待在这里",
            Word(Kind.NOT): "不要 | 不 | 别 | 勿 | 不能 | 无需 | 不需要 | 无法 | 没有 | 不必",
            Word(Kind.POSSIBLE): "可以 | 可能 | 能否 | 能够",
            Word(Kind.CONDITION): "如果 | 因为 | 当 | 是否 | 由于",
            Word(Kind.JOIN): "然后 | 然後 | 并 | 并且 | 再 | 而是 | 因此 | 所以 | 于是 | 但 | 但是 | 接着 | 而",
            Word(Kind.OR): "或 | 或者",
            Word(Kind.SMALL): "一点 | 一下 | 稍微 | 一點",
            Word(Kind.FRESH): "我 | 我会 | 我将 | 我要 | 我应该 | 我需要 | 我选择 | 应该",
            Word(Kind.GAZE): "视线 | 目光 | 镜头 | 摄像头 | 相机",
            Word(Kind.FILLER): "将 | 把 | 请 | 约 | 大约 | 大概 | 头 | 身体 | 的 | 继续 | 先 | 直接 | 慢慢",
        }
    ),
}


def _inflected(word: Word, stems: str, endings: str) -> dict[str, Word]:
    """Return a table of every stem with every ending; blanks separate them, and `-` is an empty ending."""
    return {stem + ending.replace("-", ""): word for stem in stems.split() for ending in endings.split()}


def _before(act: Act, *ways: Way) -> Word:
    return Word(Kind.VERB, act=act, side=Side.BEFORE, ways=ways, goes=True)


_GODAN = {
    "む": (
        "む み みます もう みたい んで みましょう みなさい め むべきです",
        "んだ みました んでいました んでいた",
        "んでいる んでいます",
    ),
    "る": (
        "る り ります ろう りたい って りましょう れ るべきです",
        "った りました っていました っていた",
        "っている っています",
    ),
    "く": (
        "く き きます こう きたい いて きましょう け くべきです",
        "いた きました いていました いていた",
        "いている いています",
    ),
    "す": ("す し します そう したい して しましょう せ", "した しました していました", "している しています"),
}
_ICHIDAN = ("る ます よう たい て ましょう ろ", "た ました ていました ていた", "ている ています")
_SURU = (
    "- する します しよう したい して しましょう せよ しろ し すべきです",
    "した しました していました していた してしまいました",
    "している しています できる できます できるか できません できない できるように できそう は の より 中",
)
_AFTERWARDS = (
    "ため ために ためには には ように 前に と れば のは のが のを のではなく 代わりに かどうか "
    "か かもしれません 場合 途中 際 様子 人 ロボット"
)
"""Words after a plain form of a verb that make it no command."""
_NEGATED = "しない しません せず しないで せずに"


def _verbs(word: Word, stems: str, endings: tuple[str, str, str]) -> dict[str, Word]:
    """Return a table of verbs in the forms for commands, for the past, and for other statements."""
    asking, past, told = endings
    plain = [ending for ending in asking.split() if ending in ("む", "る", "く", "す", "する")]
    polite = [ending for ending in asking.split() if ending.endswith("ます")]
    other = [
        f"{ending}{after}" for ending in plain for after in _AFTERWARDS.split() if (ending, after) != ("する", "と")
    ]
    other += [f"{ending}か" for ending in polite] + told.split()
    return {
        **_inflected(Word(Kind.UNKNOWN), stems, " ".join(other)),
        **_inflected(word, stems, asking),
        **_inflected(replace(word, form=Form.PAST), stems, past),
    }


_TURN_BACK = Word(Kind.VERB, act=Act.TURN, side=Side.BEFORE, ways=(Way.AROUND,), number=180.0)

_JAPANESE_VERBS: Table = {
    **_verbs(_before(Act.MOVE), "進", _GODAN["む"]),
    **_verbs(_before(Act.MOVE), "下が 戻", _GODAN["る"]),
    **_verbs(_before(Act.MOVE), "歩 動", _GODAN["く"]),
    **_verbs(_before(Act.MOVE), "動か", _GODAN["す"]),
    **_verbs(_before(Act.MOVE), "移動 平行移動 横移動 スライド", _SURU),
    **_verbs(_before(Act.MOVE, Way.FORWARD), "前進 直進", _SURU),
    **_verbs(_before(Act.MOVE, Way.BACK), "後退 バック", _SURU),
    **_verbs(_before(Act.MOVE, Way.BACK), "後ろに下が 後ろへ下が うしろに下が 後ずさ", _GODAN["る"]),
    **_verbs(_before(Act.TURN), "回転 旋回 方向転換 ターン", _SURU),
    **_verbs(_before(Act.TURN), "曲が 回", _GODAN["る"]),
    **_verbs(_before(Act.TURN), "体を回 身体を回", _GODAN["す"]),
    **_verbs(_before(Act.TURN), "向け 向きを変え 方向を変え 体の向きを変え", _ICHIDAN),
    **_verbs(_before(Act.TURN), "向", _GODAN["く"]),
    **_verbs(_before(Act.TURN, Way.RIGHT), "右折 右回転 右旋回", _SURU),
    **_verbs(_before(Act.TURN, Way.LEFT), "左折 左回転 左旋回", _SURU),
    **_verbs(_TURN_BACK, "振り返 後ろを振り返", _GODAN["る"]),
    **_verbs(_TURN_BACK, "後ろを向 うしろを向 反対を向 反対方向を向 振り向", _GODAN["く"]),
    **_verbs(_before(Act.LOOK), "見", _ICHIDAN),
    **_verbs(_before(Act.LOOK), "視線を移 傾け", _GODAN["す"]),
    **_verbs(_before(Act.LOOK), "傾け", _ICHIDAN),
    **_verbs(_before(Act.LOOK, Way.UP), "見上げ 上げ", _ICHIDAN),
    **_verbs(_before(Act.LOOK, Way.DOWN), "見下ろ 落と", _GODAN["す"]),
    **_verbs(_before(Act.LOOK, Way.DOWN), "下げ", _ICHIDAN),
    **_verbs(_before(Act.LOOK, Way.DOWN), "うつむ", _GODAN["く"]),
}

_OTHERS = (
    "ロボット 人 人物 男性 女性 宇宙飛行士 飛行士 彼 彼女 エージェント 誰か 作業員 子供 犬 研究者 スタッフ 人々 男 女"
)

_JAPANESE_TOLD: Table = {
    **phrases(
        {
            Word(Kind.PAST, reach="before"): "ました | ませんでした | でした | だった | たが | たので | たため | "
            "た結果 | た後 | たあと | た際 | たところ | たとき | た時 | たけど | たけれど | だ後 | んだが | "
            "んだので | んだ結果 | んだため | んだところ | ましたが | ました後",
            Word(Kind.EARLIER): "前回 | 前回は | 前回の | 前のステップ | 前のステップで | 前のステップでは | "
            "先ほど | 先ほどは | さっき | 直前 | 直前の | 以前 | これまで | 前の動作 | 前の動作は | 前の行動 | "
            "最後の動作 | 最後の動作は | 一つ前 | 履歴 | 直前に",
            Word(Kind.NOW): "次は | 今回は | 今は | 今回 | 今 | ここでは | 今回の動作は | 次の動作は | 次の動作 | "
            "次の行動は | 次の行動 | 今度は | 次の移動 | 次の移動は | 次の一手は | このステップでは",
            Word(Kind.LATER): "次回 | 次回以降 | 後で | あとで | いずれ | 最終的に | 最終的には | 将来 | 後ほど | "
            "その後で | いつか | そのうち | やがて",
            Word(Kind.NEXT): "次のステップで | 次のステップでは | 次のターンで | つもり | 予定 | その次に | その次は",
            Word(Kind.FIRST): "その前に | でもまず | ただしまず | しかしまず | が、まず | ですが、まず",
            Word(Kind.RETRACT): "いや、 | いいえ、 | 訂正 | やはり | やっぱり | 間違えました | いえ、 | 待って",
        }
    ),
    **{f"{name}{marker}": Word(Kind.OTHER, reach="both") for name in _OTHERS.split() for marker in "がは"},
    **phrases(
        {
            Word(Kind.OTHER, reach="both"): "目標は、 | 目的は | 任務は | 課題は | タスクは | 私の目標は | "
            "私の任務は | 目標は",
        }
    ),
}
"""Words for reports instead of commands: the past, other agents, purposes, postponed motions."""

JAPANESE: Table = {
    **_JAPANESE_TOLD,
    **_inflected(Word(Kind.WAY, ways=(Way.FORWARD,)), "前 まえ 正面 前方", "に へ 方向に 方に の方に 方向へ"),
    **phrases(
        {
            Word(Kind.WAY, ways=(Way.FORWARD,)): "まっすぐ前に | まっすぐ | 真っ直ぐ | まっすぐに | 真っすぐ",
        }
    ),
    **_inflected(Word(Kind.WAY, ways=(Way.BACK,)), "後ろ うしろ 後方", "に へ 方向に の方に 方向へ"),
    **_inflected(Word(Kind.WAY, ways=(Way.LEFT,)), "左", "に へ を 方向に 方向へ の方に の方を の方へ 側に 向きに"),
    **_inflected(Word(Kind.WAY, ways=(Way.RIGHT,)), "右", "に へ を 方向に 方向へ の方に の方を の方へ 側に 向きに"),
    **phrases(
        {
            Word(Kind.WAY, ways=(Way.LEFT,)): "反時計回りに | 反時計回り | 反時計方向に",
            Word(Kind.WAY, ways=(Way.RIGHT,)): "時計回りに | 時計回り | 時計方向に",
        }
    ),
    **_inflected(Word(Kind.WAY, ways=(Way.FORWARD, Way.LEFT)), "左前 左前方 左斜め前 斜め左前", "に へ 方に"),
    **_inflected(Word(Kind.WAY, ways=(Way.FORWARD, Way.RIGHT)), "右前 右前方 右斜め前 斜め右前", "に へ 方に"),
    **_inflected(Word(Kind.WAY, ways=(Way.BACK, Way.LEFT)), "左後ろ 左斜め後ろ 斜め左後ろ", "に へ 方に"),
    **_inflected(Word(Kind.WAY, ways=(Way.BACK, Way.RIGHT)), "右後ろ 右斜め後ろ 斜め右後ろ", "に へ 方に"),
    **_inflected(Word(Kind.WAY, ways=(Way.UP,)), "上", "に へ を 方向に 方向を の方を 向きに"),
    **_inflected(Word(Kind.WAY, ways=(Way.DOWN,)), "下", "に へ を 方向に 方向を の方を 向きに"),
    **phrases(
        {
            Word(Kind.NOT, reach="before"): "しない | しません | せず | しないで",
        }
    ),
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
    **_inflected(Word(Kind.STAY), "停止 待機 静止", "- する します して"),
    **phrases(
        {
            Word(Kind.STAY): "何もしない | 何もしません | 待つ | 待ちます | そのまま | 現在の位置を維持 | "
            "現在位置を維持 | 留まります | 止まっています | 動かずに",
            Word(Kind.PLACE): "その場に | その場で | ここに | ここで | 現在の位置に | 現在位置に",
            Word(Kind.SMALL): "少し | すこし | ちょっと | 少しだけ | わずかに",
            Word(Kind.FILLER): "に | へ | を | だけ | ほど | くらい | ぐらい | 約 | およそ | さらに | もう | 体を | "
            "体の | 分 | で | ゆっくり | ゆっくりと | 身体を | 再び | まず | もう一度 | 方向 | ことにします | "
            "ことにする | ことにしました | ことです | ことだ | ことを選びます | ことを選択します | ことが必要です | "
            "ことが最善です | ことが最適です | ことがよい | ことを決めました | 決めました | 選びました | 選択しました",
            Word(Kind.GAZE): "視線を | 顔を | カメラを | 頭を | 目線を | 首を | 視線 | カメラ",
            Word(Kind.JOIN): "その後 | それから | 次に | そして | してから | したがって | 従って | そのため | "
            "だから | よって | ので | しかし | でも | ため、",
            Word(Kind.OR): "または | もしくは | あるいは",
            Word(Kind.POSSIBLE, reach="before"): "こと",
            Word(Kind.CLOSE): "に向かって | へ向かって | に沿って | 向かって | の方へ | に近づくために | に近づくため",
            Word(Kind.CONDITION): "もし",
            Word(Kind.NOT, reach="before"): "必要はありません | 必要はない | わけにはいきません | べきではありません",
            Word(Kind.FRESH): "私は | 私が | 僕は | わたしは",
            Word(Kind.EXAMPLE): "例: | 例えば | たとえば | 例として",
            Word(Kind.UNKNOWN): "向いている | 向いています | 向いて | 見るため | 進むため | 進むと | 回転すると | "
            "回転すれば",
            Word(Kind.UNIT, dimension=Dimension.LENGTH, number=1.0): "メートル | メーター | 米",
            Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.01): "センチメートル | センチ | 厘米 | 公分",
            Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.001): "ミリメートル | ミリ | 毫米",
            Word(Kind.UNIT, dimension=Dimension.LENGTH, number=1000.0): "キロメートル | キロ | 公里",
            Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.3048): "フィート | 英尺",
            Word(Kind.UNIT, dimension=Dimension.LENGTH, number=0.0254): "インチ | 英寸",
            Word(Kind.UNIT, dimension=Dimension.STEP, number=1.0): "歩 | 步",
            Word(Kind.UNIT, dimension=Dimension.ANGLE, number=1.0): "度",
            Word(Kind.UNIT, dimension=Dimension.OTHER): "秒 | 回 | 次",
        }
    ),
    **numbers("〇=0 一=1 二=2 三=3 四=4 五=5 六=6 七=7 八=8 九=9 两=2 半=0.5"),
    **numbers("十=10 百=100", scale=True),
    **_JAPANESE_VERBS,
}
