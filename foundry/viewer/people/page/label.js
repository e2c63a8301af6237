"use strict";
/* Shows one text at a time and sends the label that the person gives. */
(function (foundry) {
  const {h, fill, announce} = foundry.dom;
  const main = document.getElementById("main"), bar = document.getElementById("progress"), end = document.getElementById("end");
  let person = "", place = null, isBusy = false;

  async function ask(path, sent) {
    const reply = await fetch(path, sent && {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(sent)});
    const answer = await reply.json();
    if (!reply.ok) throw new Error(answer.error);
    return answer;
  }

  function tell(text) {
    const problem = main.querySelector(".warning");
    fill(problem, text);
    problem.hidden = false;
  }

  /** Run an action that changes the current text, one at a time. A second key press during an action has no effect. */
  async function go(step, shown, stored) {
    if (isBusy) return;
    isBusy = true;
    try { shown(await step(), stored); }
    catch (error) { tell(error instanceof TypeError ? "The command that served this page has ended. Your labels are saved." : error.message); }
    finally { isBusy = false; }
  }

  const label = (choice) => go(() => ask("label", {person, item: place.shown.item, label: choice}), show, `Your label ${choice} is saved. `);
  const undo = () => go(() => ask("undo", {person}), show, "Your last label is removed. ");
  const enter = () => go(() => ask(`place?person=${encodeURIComponent(person)}`), show, "");

  /** Show the current text. Screen readers announce the stored label and the next text. */
  function show(now, stored) {
    place = now;
    end.hidden = false;
    fill(bar, `${person}: ${now.done} of ${now.total} labelled `, h("progress", {max: now.total || 1, value: now.done, "aria-label": "Labelled texts"}));
    const back = h("button", {type: "button", class: "undo", disabled: !now.can_undo, onclick: undo}, "Undo my last label ", h("kbd", {}, "Backspace"));
    const problem = h("p", {class: "warning", role: "alert", hidden: true});
    if (!now.shown) {
      fill(main, h("section", {class: "label-card"}, h("h1", {}, "All texts are labelled"), h("p", {}, "Thank you. Your labels are saved. You can end for today."), problem, back));
      announce(`${stored}All texts are labelled.`);
    } else {
      const {text, question, guidance, told: prompt, choices} = now.shown;
      fill(main, h("section", {class: "label-card"},
        h("h1", {class: "unseen"}, "Text to label"),
        h("blockquote", {class: "text", dir: "auto"}, text),
        h("p", {class: "question"}, question),
        h("div", {class: "choices", role: "group", "aria-label": "Your label"},
          choices.map(([key, choice]) => h("button", {type: "button", class: "button", onclick: () => label(choice)}, `${choice} `, h("kbd", {}, key)))),
        problem, back, guidance.map((part) => h("p", {class: "guidance", dir: "auto"}, part)),
        prompt ? h("details", {}, h("summary", {}, "The prompt of the agent"), h("pre", {class: "told", dir: "auto"}, prompt)) : null));
      announce(`${stored}Text ${now.done + 1} of ${now.total}: ${text}`);
      window.scrollTo(0, 0);
    }
    main.focus({preventScroll: true});
  }

  function begin() {
    const name = h("input", {type: "text", maxlength: 40, required: true, pattern: "[A-Za-z0-9_][A-Za-z0-9_\\-]*", autocomplete: "off", "aria-label": "Your name here", value: sessionStorage.getItem("person") || ""});
    const problem = h("p", {class: "warning", role: "alert", hidden: true});
    const form = h("form", {class: "label-card", novalidate: true}, h("h1", {}, "Before you begin"),
      h("p", {}, "You will read texts and label each of them. You will not see which model wrote a text."),
      h("p", {}, "The sweep records your labels under the name that you give below, and the seconds that you took for each label. Nothing else about you is recorded. You can stop at any time and continue on another day."),
      h("label", {}, "Your name or a made-up word, such as p07. Use only letters, digits, - and _ ", name), problem,
      h("button", {class: "button", type: "submit"}, "I agree, begin ", h("kbd", {}, "Enter")));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      if (!name.checkValidity()) { tell(`'${name.value}' is not a valid name. Use letters, digits, - and _.`); return; }
      person = name.value;
      sessionStorage.setItem("person", person);
      enter();
    });
    fill(main, form);
    name.focus();
  }

  document.addEventListener("keydown", (event) => {
    if (!place || event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    if (event.key === "Backspace" && place.can_undo) { event.preventDefault(); undo(); return; }
    const chosen = place.shown && place.shown.choices.find(([key]) => key === event.key.toLowerCase());
    if (chosen) { event.preventDefault(); label(chosen[1]); }
  });
  function leave({others}) {
    place = null;
    end.hidden = true;
    fill(bar);
    const more = others ? [h("p", {}, "Other people are still labelling, so you can continue."), h("button", {type: "button", class: "button", onclick: enter}, "Go on")] : null;
    fill(main, h("section", {class: "label-card"}, h("h1", {}, "That is all for now"), h("p", {}, "Your labels are saved. You can close this page."), h("p", {class: "warning", role: "alert", hidden: true}), more));
    announce("That is all for now. Your labels are saved.");
    main.focus({preventScroll: true});
  }

  end.addEventListener("click", () => go(() => ask("end", {person}), leave));
  ask("title").then((reply) => { fill(document.getElementById("title"), reply.title); begin(); });
})(window.Foundry);
