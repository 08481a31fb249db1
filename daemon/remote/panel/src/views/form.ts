// One form: it sends one action and shows the answer beside the button that was pressed. A refusal lies over what is
// below, until the next press elsewhere or the next answer.
import type { Actions } from "../actions";
import { setData, setText } from "../dom";

type Body = () => Record<string, unknown> | { refused: string };

/** A button may have an action of its own. Connects a form: `body` returns the order or the reason for not sending it; `sent` is called after acceptance. */
export function wire(form: HTMLFormElement, act: Actions, body: Body, sent: () => void = () => undefined): void {
    const answer = form.querySelector("output")!;
    const first = form.querySelector<HTMLButtonElement>("button:not([type=button])")!;
    const say = (kind: string, text: string): void => {
        setData(answer, "kind", kind);
        setText(answer, text);
    };
    document.addEventListener("pointerdown", ({ target }) => {
        if (answer.dataset["kind"] === "error" && !(target instanceof Node && form.contains(target))) say("", "");
    });
    let number = 0;
    form.addEventListener("submit", (event) => {
        event.preventDefault();
        const { submitter } = event;
        const button = submitter instanceof HTMLButtonElement ? submitter : first;
        if (button.getAttribute("aria-busy") === "true") return;
        const content = body();
        if ("refused" in content) return say("error", String(content["refused"]));
        const mine = ++number;
        button.setAttribute("aria-busy", "true");  // disabling it would take the focus away
        say("busy", "…");
        void act(button.dataset["action"] ?? form.dataset["action"]!, content).then((result) => {
            button.removeAttribute("aria-busy");
            if (!result.ok) return say("error", result.error);
            say("ok", "✓");
            setTimeout(() => { if (mine === number && answer.dataset["kind"] === "ok") say("", ""); }, 3000);
            sent();
        });
    });
}
