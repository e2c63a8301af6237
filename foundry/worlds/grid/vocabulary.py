"""Names of the keys, actions and directions of a reply in several languages."""

from __future__ import annotations

KEYS = {
    "action": (
        "action", "actions", "my action", "chosen action", "final action", "next action", "decision", "my decision",
        "final decision", "action type", "actiontype", "aktion", "handlung", "entscheidung", "acción", "accion",
        "décision", "azione", "ação",
        "acao", "actie", "akcja", "действие", "行動", "アクション", "動作", "行动", "动作", "행동", "동작",
    ),
    "direction": (
        "direction", "move direction", "dir", "heading", "richtung", "dirección", "direccion", "direzione",
        "direção", "direcao",
        "richting", "kierunek", "направление", "方向", "방향",
    ),
    "message": (
        "message", "my message", "msg", "nachricht", "botschaft", "mensaje", "messaggio", "mensagem", "bericht",
        "wiadomość", "сообщение", "メッセージ", "伝言", "消息", "信息", "讯息", "메시지",
    ),
    "memory": (
        "memory", "memories", "gedächtnis", "erinnerung", "mémoire", "memoria", "memória", "geheugen", "pamięć",
        "память", "記憶", "メモリ", "メモリー", "メモ", "记忆", "기억",
    ),
    "reasoning": (
        "reasoning", "reason", "explanation", "rationale", "thoughts", "thought", "thinking", "begründung",
        "raisonnement", "raison",
        "razonamiento", "razón", "ragionamento", "motivo", "raciocínio", "redenering", "reden", "uzasadnienie",
        "обоснование", "причина", "理由", "推論", "原因", "推理", "解释", "이유", "추론",
    ),
}  # fmt: skip
"""The names of each key; the first one is the requested name."""

UP, DOWN, LEFT, RIGHT, STAY, MOVE = "up", "down", "left", "right", "stay", "move"

MEANINGS = {
    UP: (
        "up", "upward", "upwards", "upper", "north", "northward", "northwards", "above", "↑", "⬆", "🔼", "👆", "⇧",
        "y+1", "+y", "increase y", "increase the y", "positive y", "y increases", "y increase",
        "oben", "hoch", "aufwärts", "hinauf", "rauf", "norden", "haut", "monter", "nord", "arriba", "norte", "subir",
        "su", "in alto", "l'alto", "cima", "acima", "omhoog", "boven", "noorden", "góra", "górę", "górze",
        "północ", "вверх",
        "наверх", "север", "上", "上方", "上方向", "上側", "北", "向上", "往上", "朝上", "上边", "上面", "위",
        "위로", "위쪽", "북쪽",
    ),
    DOWN: (
        "down", "downward", "downwards", "lower", "south", "southward", "southwards", "below", "↓", "⬇", "🔽",
        "👇", "⇩",
        "y-1", "-y", "decrease y", "decrease the y", "negative y", "y decreases", "y decrease",
        "unten", "abwärts", "runter", "hinunter", "herunter", "süden", "bas", "descendre", "sud", "abajo", "sur",
        "bajar", "giù", "basso", "baixo", "abaixo", "omlaag", "beneden", "onder", "zuiden", "dół", "dole", "południe",
        "вниз", "юг", "下", "下方", "下方向", "下側", "南", "向下", "往下", "朝下", "下边", "下面", "아래",
        "아래로", "아래쪽", "남쪽",
    ),
    LEFT: (
        "left", "leftward", "leftwards", "west", "westward", "westwards", "←", "⬅", "👈", "⇦", "◀",
        "x-1", "-x", "decrease x", "decrease the x", "negative x", "x decreases", "x decrease",
        "links", "westen", "linke", "linken", "gauche", "ouest", "izquierda", "oeste", "sinistra", "ovest",
        "esquerda", "lewo", "lewa",
        "zachód", "влево", "налево", "запад", "左", "左側", "左方", "左方向", "西", "向左", "往左", "朝左", "左边",
        "左面",
        "왼쪽", "왼쪽으로", "좌측", "서쪽",
    ),
    RIGHT: (
        "right", "rightward", "rightwards", "east", "eastward", "eastwards", "→", "➡", "👉", "⇨", "▶",
        "x+1", "+x", "increase x", "increase the x", "positive x", "x increases", "x increase",
        "rechts", "osten", "rechte", "rechten", "droite", "derecha", "este", "destra", "direita", "leste",
        "rechtsaf", "oosten", "prawo",
        "prawa", "wschód", "вправо", "направо", "восток", "右", "右側", "右方", "右方向", "東", "东", "向右",
        "往右", "朝右",
        "右边", "右面", "오른쪽", "오른쪽으로", "우측", "동쪽",
    ),
    STAY: (
        "stay", "stays", "staying", "wait", "waits", "waiting", "remain", "remains", "remaining", "stay put",
        "stand still", "keep still", "stay still", "hold position", "hold", "idle", "do nothing",
        "stay where i am", "remain where i am",
        "stationary", "stand", "standing", "rest", "pause", "stop", "keep position", "maintain position", "still",
        "keep my position", "stehenbleiben", "rester sur place", "sur place", "정지", "멈춤", "멈추기", "머물러",
        "静止", "停止",
        "残る", "そのまま", "保持",
        "bleiben", "bleibe", "bleib", "warten", "warte", "stehen bleiben", "rester", "reste", "attendre", "quedarse",
        "quedarme", "permanecer", "esperar", "restare", "rimanere", "aspettare", "ficar", "aguardar", "blijven",
        "blijf", "wachten", "zostać", "zostań", "zostaję", "czekać", "pozostać", "остаться", "остаюсь", "оставаться",
        "стоять", "ждать", "留まる", "とどまる", "止まる", "待つ", "待機", "待機する", "その場に留まる",
        "その場にとどまる", "滞在",
        "停留", "留", "留下", "等待", "不动", "保持不动", "原地不动", "待在原地", "留在原地", "머무르기",
        "머무르다", "머무름", "머물기", "머물다",
        "대기", "유지", "가만히 있기",
    ),
    MOVE: (
        "move", "moves", "moving", "go", "goes", "going", "walk", "walks", "walking", "run", "running", "head",
        "heading", "step", "travel", "proceed", "advance", "continue", "keep moving", "keep going", "flee",
        "escape", "turn", "shift", "evacuate",
        "bewegen", "bewege", "bewegung", "gehen", "gehe", "geh", "laufen", "aller", "bouger", "se déplacer",
        "déplacer", "déplacement", "mouvement", "avancer", "mover", "moverse", "moverme", "mueve", "moverte", "ir",
        "avanzar", "caminar", "muovere", "muoversi", "muoviti", "spostarsi", "andare", "andar", "bewegen", "gaan",
        "lopen", "ruch", "idź", "iść", "ruszać", "przesunąć się", "двигаться", "идти", "иди", "двигайся", "движение",
        "переместиться", "移動", "移動する", "移動します", "動く", "進む", "行く", "移动", "移动到", "走", "移",
        "前进",
        "去", "이동",
        "이동하기", "이동하다", "움직이기", "움직이다", "가기",
    ),
}  # fmt: skip

FILLERS = (
    "i", "i'll", "i'm", "will", "want", "choose", "decide", "decided", "have", "and", "straight", "let's", "let",
    "us", "to", "the", "one", "1", "step", "steps", "cell",
    "unit",
    "by", "space", "side", "in", "direction", "coordinate",
    "nach", "ich", "hier", "zum", "l'", "all'", "d'", "ici", "aquí", "aqui", "qui", "sitio", "lugar", "quieto",
    "fermo", "parado",
    "месте", "здесь", "原地", "原位", "その場", "ここ", "現在地", "제자리", "제자리에", "der", "die", "eine",
    "vers", "le", "la", "à", "en", "a", "hacia", "para", "al", "el", "verso",
    "naar", "w", "na", "в", "на", "に", "へ", "を", "する", "します", "方向", "로", "으로", "하기", "하다",
)  # fmt: skip
"""Words without meaning for the decision."""

REMARKS = (
    "(", "[", ",", ":", ";", ".", "-", "–", "—", "//", "#", "/*",
    "toward", "because", "since", "so ", "as ", "to ",
)  # fmt: skip
STAYING_REMARKS = ("in ", "at ", "here", "inside", "within", "on ", "for ", "until", "where", "there")
"""Beginnings of remarks, which do not change the decision before them; the latter only after a decision to stay."""

DOUBTS = frozenset(
    ("not", "no", "don't", "dont", "never", "or", "unless", "if", "maybe", "perhaps", "possibly", "either", "then",
     "instead", "away", "except", "but", "later", "nicht", "oder", "vielleicht", "ou", "pas", "o", "не", "или",
     "または", "か", "或", "不", "또는")
)  # fmt: skip
"""Words in a remark that cast doubt on the decision before it."""

NOT_MOVING = frozenset(
    ("do not move", "don't move", "dont move", "no move", "no movement", "not move", "not moving", "nicht bewegen",
     "ne pas bouger", "no moverse", "動かない", "移動しない", "不移动", "не двигаться")
)  # fmt: skip
"""Negated motions; they mean staying if no direction is given."""

NO_DIRECTION = frozenset(("", "null", "none", "n/a", "na", "nil", "-", "--", "no direction", "なし", "无", "無"))

SILENCE = frozenset(
    ("null", "none", "n/a", "na", "nil", "undefined", "no message", "no messages", "no message to send",
     "no message needed", "no message is needed", "no message necessary", "no message sent", "no message required",
     "no message at this time", "no message for now", "not sending a message", "no need to send a message",
     "i have no message", "i have no message to send", "i don't want to send a message", "no message this step",
     "no message this time", "no message this turn", "no message to share", "no need for a message",
     "nothing to say", "nothing to share",
     "nothing to send", "none needed", "i choose not to send a message", "silence", "stay silent", "empty",
     "empty string", "blank", "left empty",
     "keine", "keine nachricht", "aucun", "aucun message", "pas de message", "ninguno", "ningún mensaje",
     "sin mensaje", "no hay mensaje", "nessuno", "nessun messaggio", "nenhuma", "nenhuma mensagem", "sem mensagem",
     "geen", "geen bericht", "brak", "brak wiadomości", "нет", "нет сообщения", "нет сообщений",
     "なし", "無し", "メッセージなし", "メッセージはありません", "特になし", "送信なし", "无", "無", "没有",
     "没有消息", "无消息", "不发送消息", "沉默", "없음",
     "메시지 없음")
)  # fmt: skip
"""Whole messages that mean silence."""

PLACEHOLDERS = (
    "message to nearby agents (max 200 words, optional if you don't want to send a message)",
    "what you tell them, 200 words at most; leave it out to say nothing",
    "近くのエージェントへのメッセージ（最大200語、送らない場合は省略可）",
    "what you say",
    "あなたの言葉",
    "your message here",
    "message here",
    "message text",
    "the message",
    "your message to nearby agents",
    "insert message here",
)
"""Placeholders for the message in prompts, and their copies by models."""

BLANKS = frozenset(("message", "text", "string", "content", "your", "insert", "optional", "brief", "short"))
"""Words that make a message in angle brackets a placeholder: "<your message>", but not "<fire near cafe>"."""
