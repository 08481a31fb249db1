// Orders of the daemon without a form of their own on this page: made from its table of orders when the page is loaded.
import type { Actions, Reader } from "../actions";
import { byId, make, setHidden } from "../dom";
import type { Store } from "../store";
import { wire } from "./form";

interface OrderField { key: string; kind: string; words?: string[]; help: string; otherwise: string; needed: boolean }
interface OrderRow { name: string; summary: string; details: string; fields: OrderField[] }
type Input = HTMLInputElement | HTMLSelectElement;

const switched = ["on", "off"];

function inputOf({ kind, words, help, otherwise }: OrderField): Input {
    const choices = kind === "flag" ? switched : words;
    if (!choices) {
        const text = make("input");
        text.autocomplete = "off";
        text.placeholder = otherwise;
        text.title = help;
        return text;
    }
    const select = make("select");
    select.title = help;
    if (otherwise) select.append(new Option(otherwise, ""));
    select.append(...choices.map((word) => new Option(word)));
    return select;
}

/** The values as typed: the daemon reads texts with units and refuses by name. */
function valuesOf(fields: OrderField[], inputs: Input[]): Record<string, unknown> {
    const typed = fields.map(({ key, kind }, k) => [key, kind, inputs[k]!.value.trim()] as const).filter(([, , text]) => text !== "");
    return Object.fromEntries(typed.map(([key, kind, text]) => [key, kind === "flag" ? text === "on" : text]));
}

function formOf(act: Actions, { name, summary, details, fields }: OrderRow): HTMLFormElement {
    const form = make("form", "row"), button = make("button"), answer = make("output", "answer");
    form.dataset["action"] = name;
    form.noValidate = true;
    button.textContent = summary;
    button.title = details;
    const inputs = fields.map(inputOf);
    fields.forEach(({ key }, k) => {
        const label = make("label");
        label.append(`${key} `, inputs[k]!);
        form.append(label);
    });
    form.append(button, answer);
    wire(form, act, () => valuesOf(fields, inputs));
    return form;
}

export function makeOrders(act: Actions, reader: Reader, store: Store): () => void {
    const box = byId("orders", HTMLElement);
    let asked = false;
    return () => {
        if (asked || !store.state) return;
        asked = true;
        void reader.json("api/orders").then((rows) => {
            if (!Array.isArray(rows)) return void (asked = false);
            const known = new Set(Array.from(document.querySelectorAll<HTMLElement>("[data-action]"), (e) => e.dataset["action"]));
            for (const row of rows as OrderRow[]) if (!known.has(row.name)) box.append(formOf(act, row));
            setHidden(box, box.querySelector("form") === null);
        });
    };
}
