"""The words by which `warning_rule` tells statements, questions and clauses, as `warning_words`."""

from __future__ import annotations

STATED = (
    "there|here|i|i'm|i've|we|we're|it|it's|that|this|the|a|an|my|our|he|she|they|agent|watch"
    "|beware|careful|warning|be|es|ich|da|dort|hier|das|der|die|wir|il|je|j'ai|nous|on|le|la"
    "|les|un|une|vedo|ho|vejo|vi|eu|я|мы|там|er|ik|wij"
)
"""Words with which a statement begins that goes before a question in one sentence: "there is a fire, shall we go?"."""

ASKED_UNSPACED = (
    "(?<!ません)(?<!ない)(?<!でしょ)か$|(?<!ない)でしょうか$|かな$|[吗嗎]|有没有|(?<!가 )(?<!이 )나요|까요|습니까"
)
"""What makes a clause a question without its mark."""

FACTIVE: dict[str, str] = {
    "English": "(?:did|do|have|has|had|can|could|don't|didn't|haven't|hasn't|can't) (?:you|u|ya|y'all"
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
    "|smell|smelled|smelt)",
    "German": "(?:habt|hast|haben|wisst|weißt|wissen|seht|siehst|sehen|merkt|merkst|riecht) (?:ihr|du"
    "|sie|jemand|alle)(?: auch| schon| nicht| denn){0,3}(?: gesehen| gehört| bemerkt"
    "| mitbekommen| gemerkt)?,? dass|(?:seht|siehst|riecht|riechst) (?:ihr|du)(?: auch| nicht"
    "| denn){0,3} (?=den |die |das |diesen |diese )|(?:habt|hast|haben) (?:ihr|du"
    "|sie) (?=(?:den|die|das|diesen|diese) )|ist (?:euch|dir|ihnen) (?:bewusst|klar"
    "|aufgefallen),? dass|(?:warum|wieso) (?:ist|sind|geht|lauft|steht|bleibt)(?: ihr| du"
    "| ihr alle| niemand)?",
    "French": "(?:vous avez|tu as|avez-vous|as-tu|t'as|n'avez-vous pas) (?:vu|remarqué|entendu|appris"
    "|su|senti|constaté)(?: que| qu'|(?= (?:le|la|les|cette|l') ?))|(?:saviez-vous|savez-vous"
    "|sais-tu|tu sais|vous savez|tu savais|vous saviez|voyez-vous|vois-tu|tu vois"
    "|vous voyez) (?:que |qu'|(?=(?:le|la|les|cette) ))|est-ce que (?:vous avez|tu as) (?:vu"
    "|remarqué|entendu)(?: que| qu'|(?= (?:le|la|les) ))|pourquoi (?:est-ce que )?",
    "Spanish": "(?:habéis|has|han|ha|hais) (?:visto|notado|oído|sabido|olido)(?: ya)? (?:que |lo que "
    "|cómo |(?=(?:el|la|las|los|ese|esa) ))|(?:sabíais|sabías|sabes|sabéis|saben|sabían|viste"
    "|vieron|visteis|ves|veis|ven|notaste|notaron|oíste|se enteraron de|te enteraste de"
    "|os enterasteis de)(?: ya)? (?:que |cómo |(?=(?:el|la|las|los|ese|esa) ))|(?:os|te"
    "|se) (?:habéis|has|han) dado cuenta de que|por qué",
    "Portuguese": "(?:vocês?|tu|já|alguém) ?(?:já )?(?:viram|viu|viste|sabiam|sabia|sabe|sabem|sabias"
    "|repararam|reparou|notaram|notou|perceberam|percebeu|ouviram|ouviu|estão vendo"
    "|está vendo)(?: que|(?= (?:o|a|os|as|aquel[ea]) ))|(?:viram|viu|viste|sabiam|sabias"
    "|sabia|repararam|reparaste|notaram|notaste|perceberam) que|por que|porque é que",
    "Italian": "(?:avete|hai|ha|hanno) (?:visto|notato|sentito|saputo|capito)(?: anche voi)? (?:che "
    "|come |(?=(?:il|la|le|gli|i|quel|quella|l') ?))|(?:sapevate|sapevi|sapete|sai|vedete"
    "|vedi|sentite|senti) (?:che |(?=(?:il|la|le|gli|quel|quella) ))|(?:vi siete"
    "|ti sei) accort[oaie] che|perché (?:siete|sei|non|state)",
    "Russian": "(?:вы|ты|кто-нибудь|все)(?: уже| тоже| не){0,3} (?:видел[аи]?|видите|видишь|знаете"
    "|знаешь|знал[аи]?|слышал[аи]?|заметил[аи]?|замечаете|в курсе"
    "|чувствуете)(?: ли)?,? (?:что|как)|(?:видел[аи]?|видите|видишь|знаете|знаешь|слышал[аи]?"
    "|заметил[аи]?)(?: вы| ты)?,? (?:что|как)|почему (?:вы|ты|никто|все)?(?: ещё| еще| не)?",
    "Dutch": "(?:hebben|heb|heeft) (?:jullie|je|jij|u|iemand)(?: al| ook| niet){0,3} (?:gezien|gehoord"
    "|gemerkt|opgemerkt|doorgehad|geroken) (?:dat|hoe)|(?:weten|weet|wisten|wist|zien|zie"
    "|ruiken|ruik) (?:jullie|je|jij|u)(?: al| ook| niet| wel){0,3} (?:dat|(?=(?:de|het"
    "|die) ))|(?:hebben|heb) (?:jullie|je) (?=(?:de|het|die) )|waarom (?:is|zijn|staat|lopen"
    "|loop)(?: jullie| je)?",
    "Polish": "(?:czy )?(?:wy |ty )?(?:widzieliście|widziałeś|widziałaś|widzicie|widzisz|wiecie|wiesz"
    "|wiedzieliście|wiedziałeś|wiedziałaś|słyszeliście|słyszałeś|słyszałaś|zauważyliście"
    "|zauważyłeś|zauważyłaś|czujecie)(?: już)?,? (?:że|jak)|dlaczego|czemu",
}
"""Beginnings of questions that take for granted what follows them: "did you notice that the bar burns?"."""

FACTIVE_UNSPACED = (
    "(?:(?:の|こと)[はをにが]?|って|と)、?(?:もう|みんな|皆さん)?(?:見え(?:ま|る|た)|見ま"
    r"|見た|見て|気づ|気付|知って|知らな|ご存|聞き|聞いた|わかり)[^?。]{0,10}\?|(?:知道|听说"
    "|注意到|发现|聽說)(?=[^?。]{2,40}[吗嗎])|看[到见](?=[^?。有哪什]{2,12}(?:起火|着火|冒烟"
    "|在烧|燃烧|失火|烧起来))|为什么|(?:거|것|걸|건|사실|게)(?:은|을|를|이)? ?(?:봤|보셨|보았"
    r"|보이|보여|아세요|아시|알고|알아|알았|들었|들으셨|못 ?봤|눈치)[^?.]{0,10}\?"
)
"""The same where no blanks stand between words; some stand at the end."""

LINKS = (
    "but|and|so|because|since|while|although|though|however|as(?! chamas)|then|due to|und"
    "|aber|doch|denn|weil|sondern|et|(?<!há )mais|car|parce que|donc|(?<!il )y(?! a)|pero"
    "|porque|así que|mas|então|(?<!nie )ma|perché|quindi|и|но|а|потому что|maar|want (?:er"
    "|het|de|ik)|en (?:ik|er|het|de|we|ga|kom|blijf)|ale|więc"
)
LINKS_UNSPACED = "(?<=[すただい])(?:が|けれども?|けど|ので|から|ため|し)|但是|但|所以|因此|而且|지만|니까|(?<=[다요]) "
"""What begins another clause."""
