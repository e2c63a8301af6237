"""The Chinese words, which are written without blanks."""

from __future__ import annotations

from dataclasses import replace

from foundry.worlds.camera.language.words import Act, Form, Kind, Side, Table, Way, Word, phrases

_BOTH = Side.BOTH
_VERBS = (
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

_TOLD: Table = {
    **phrases(
        Word(Kind.EARLIER),
        "上一步 | 上一次 | 上次 | 刚才 | 刚刚 | 之前 | 先前 | 此前 | 前一步 | 已经 | 曾 | 曾经 | "
        "在上一步 | 在上一步中 | 前几步 | "
        "上一个动作 | 上一步动作 | 历史记录 | 我说 | 你说",
    ),
    **phrases(Word(Kind.PAST), "试图 | 尝试了 | 想要 | 曾试图 | 尝试过"),
    **phrases(
        Word(Kind.NOW),
        "现在 | 这次 | 这一步 | 本次 | 此刻 | 目前 | 下一步动作 | 下一步行动 | 下一个动作 | 下一步的动作 | "
        "我的下一步 | 接下来",
    ),
    **phrases(
        Word(Kind.LATER),
        "以后 | 稍后 | 之后再 | 下次 | 随后再 | 等会 | 待会 | 最终 | 下一次 | 然后下一步 | 后面再 | 以后再",
    ),
    **phrases(Word(Kind.NEXT), "下一步 | 在下一步 | 下一步再 | 在下一步中 | 下一轮"),
    **phrases(Word(Kind.FIRST), "但首先 | 但先 | 不过先 | 但在此之前 | 但要先 | 但我先 | 但是先 | 在此之前"),
    **phrases(Word(Kind.RETRACT), "不， | 不, | 不对 | 等等 | 等一下 | 更正 | 我是说 | 纠正"),
    **phrases(
        Word(Kind.OTHER),
        "机器人 | 人 | 宇航员 | 男人 | 女人 | 他 | 她 | 它 | 有人 | 行人 | 男子 | 女子 | 代理 | 智能体 | 人员 | 他们",
    ),
    **phrases(Word(Kind.PURPOSE), "为了 | 以便 | 为 | 目标是 | 任务是 | 目的是 | 我的目标是 | 我的任务是"),
}
"""What is told instead of asked for: the past, others, purposes, what is put off."""

CHINESE: Table = {
    **_TOLD,
    **{name: verb for verb, names in _VERBS for name in names.split()},
    **{
        f"{name}{ending}": replace(verb, form=Form.PAST)
        for verb, names in _VERBS
        for name in names.split()
        for ending in ("了", "过了", "过")
    },
    **phrases(Word(Kind.WAY, ways=(Way.FORWARD,)), "向前 | 往前 | 向前方 | 朝前 | 向正前方 | 径直向前"),
    **phrases(Word(Kind.WAY, ways=(Way.BACK,)), "向后 | 往后 | 向後 | 朝后"),
    **phrases(Word(Kind.WAY, ways=(Way.LEFT,)), "向左 | 往左 | 朝左 | 逆时针 | 向左侧 | 左向"),
    **phrases(Word(Kind.WAY, ways=(Way.RIGHT,)), "向右 | 往右 | 朝右 | 顺时针 | 向右侧 | 右向"),
    **phrases(Word(Kind.WAY, ways=(Way.UP,)), "向上 | 往上 | 朝上"),
    **phrases(Word(Kind.WAY, ways=(Way.DOWN,)), "向下 | 往下 | 朝下"),
    **phrases(
        Word(Kind.STAY),
        "原地不动 | 保持不动 | 停留 | 停留在原地 | 不动 | 留在原地 | 待在原地 | 停在原地 | 不移动 | 保持静止 | "
        "静止不动 | 留在这里 | 停下 | 停止 | 原地等待 | 保持原位 | 待在这里",
    ),
    **phrases(Word(Kind.NOT), "不要 | 不 | 别 | 勿 | 不能 | 无需 | 不需要 | 无法 | 没有 | 不必"),
    **phrases(Word(Kind.POSSIBLE), "可以 | 可能 | 能否 | 能够"),
    **phrases(Word(Kind.CONDITION), "如果 | 因为 | 当 | 是否 | 由于"),
    **phrases(Word(Kind.JOIN), "然后 | 然後 | 并 | 并且 | 再 | 而是 | 因此 | 所以 | 于是 | 但 | 但是 | 接着 | 而"),
    **phrases(Word(Kind.OR), "或 | 或者"),
    **phrases(Word(Kind.SMALL), "一点 | 一下 | 稍微 | 一點"),
    **phrases(Word(Kind.FRESH), "我 | 我会 | 我将 | 我要 | 我应该 | 我需要 | 我选择 | 应该"),
    **phrases(Word(Kind.GAZE), "视线 | 目光 | 镜头 | 摄像头 | 相机"),
    **phrases(Word(Kind.FILLER), "将 | 把 | 请 | 约 | 大约 | 大概 | 头 | 身体 | 的 | 继续 | 先 | 直接 | 慢慢"),
}
