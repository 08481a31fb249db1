// One form: it sends one action and shows the answer beside the button that was pressed. A refusal lies over what is
// below, until the next press elsewhere, the next letter in a field, or the next answer.
import type { Actions } from "../actions";
import { make, setData, setText } from "../dom";

export type Refused = { refused: string };
type Body = () => Record<string, unknown> | Refused;

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
    form.addEventListener("input", () => { if (answer.dataset["kind"] === "error") say("", ""); });
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

/** Shows in a line what a form will send. While its texts cannot be sent, the line has the reason and its buttons are disabled. */
export function showSent(form: HTMLFormElement, line: HTMLElement, look: string | Refused): void {
    const refused = typeof look !== "string";
    setText(line, refused ? look.refused : look);
    setData(line, "kind", refused ? "error" : "");
    for (const button of form.querySelectorAll<HTMLButtonElement>("button:not([type=button])")) button.disabled = refused;
}

/** Adds such a line to the end of a form. Returns what shows `look` again; typing does so, too. */
export function watchForm(form: HTMLFormElement, look: () => string | Refused): () => void {
    const line = make("p", "note will");
    line.setAttribute("role", "status");
    form.append(line);
    const show = (): void => showSent(form, line, look());
    form.addEventListener("input", show);
    show();
    return show;
}
