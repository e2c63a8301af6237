"""What Japanese and Chinese tell instead of asking: the past, others, purposes, what is put off."""

from __future__ import annotations

from foundry.worlds.camera.language.vocabulary.words import Kind, Table, Word, phrases

_OTHERS = (
    "ロボット 人 人物 男性 女性 宇宙飛行士 飛行士 彼 彼女 エージェント 誰か 作業員 子供 犬 研究者 スタッフ 人々 男 女"
)

JAPANESE_TOLD: Table = {
    **phrases(
        Word(Kind.PAST, reach="before"),
        "ました | ませんでした | でした | だった | たが | たので | たため | た結果 | た後 | たあと | "
        "た際 | たところ | たとき | "
        "た時 | たけど | たけれど | だ後 | んだが | んだので | んだ結果 | んだため | んだところ | ましたが | ました後",
    ),
    **phrases(
        Word(Kind.EARLIER),
        "前回 | 前回は | 前回の | 前のステップ | 前のステップで | 前のステップでは | 先ほど | 先ほどは | "
        "さっき | 直前 | 直前の | "
        "以前 | これまで | 前の動作 | 前の動作は | 前の行動 | 最後の動作 | 最後の動作は | 一つ前 | 履歴 | 直前に",
    ),
    **phrases(
        Word(Kind.NOW),
        "次は | 今回は | 今は | 今回 | 今 | ここでは | 今回の動作は | 次の動作は | 次の動作 | 次の行動は | "
        "次の行動 | 今度は | "
        "次の移動 | 次の移動は | 次の一手は | このステップでは",
    ),
    **phrases(
        Word(Kind.LATER),
        "次回 | 次回以降 | 後で | あとで | いずれ | 最終的に | "
        "最終的には | 将来 | 後ほど | その後で | いつか | そのうち | やがて",
    ),
    **phrases(
        Word(Kind.NEXT), "次のステップで | 次のステップでは | 次のターンで | つもり | 予定 | その次に | その次は"
    ),
    **phrases(Word(Kind.FIRST), "その前に | でもまず | ただしまず | しかしまず | が、まず | ですが、まず"),
    **phrases(Word(Kind.RETRACT), "いや、 | いいえ、 | 訂正 | やはり | やっぱり | 間違えました | いえ、 | 待って"),
    **{f"{name}{marker}": Word(Kind.OTHER, reach="both") for name in _OTHERS.split() for marker in "がは"},
    **phrases(
        Word(Kind.OTHER, reach="both"),
        "目標は、 | 目的は | 任務は | 課題は | タスクは | 私の目標は | 私の任務は | 目標は",
    ),
}

CHINESE_TOLD: Table = {
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
