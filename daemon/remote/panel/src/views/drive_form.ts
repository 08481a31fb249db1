// The form with the four numbers of the drive. A field shows the daemon's value until it is edited; only edited fields
// are sent, by this form or by the start of a run.
import type { Actions } from "../actions";
import { byId, setText } from "../dom";
import { paperG } from "../groups";
import type { Drive, SetPoint, State } from "../protocol";
import { typed, type Typed } from "../quantity";
import type { Store } from "../store";
import { showSent, wire, type Refused } from "./form";

type Key = "frequency_hz" | "gamma_mps2" | "rho" | "phi_rad";
type Body = Record<string, unknown>;

const units: Record<string, number> = { g: paperG, "m/s^2": 1, deg: Math.PI / 180, rad: 1 };

class Field {
    readonly input: HTMLInputElement;
    private readonly select: HTMLSelectElement | null;
    private inUnit: string;
    edited = false;

    /** unit: of a field without a choice of units. */
    constructor(readonly key: Key, readonly name: string, unit: string) {
        this.input = byId(`drive-${name}`, HTMLInputElement);
        const select = document.getElementById(`drive-${name}-unit`);
        this.select = select instanceof HTMLSelectElement ? select : null;
        this.inUnit = this.select?.value ?? unit;
        this.select?.addEventListener("change", () => this.convert());
    }

    get typed(): Typed | Refused { return typed(this.name, this.input.value, this.inUnit); }

    set value(si: number | null) {
        const text = si === null ? "" : String(Number((si / this.factor).toPrecision(9)));
        if (this.input.value !== text) this.input.value = text;
    }

    mark(edited: boolean): void {
        this.edited = edited;
        this.input.classList.toggle("edited", edited);
    }

    private get factor(): number { return units[this.inUnit] ?? 1; }

    /** A text with a unit of its own stays. */
    private convert(): void {
        const before = this.typed, factor = this.factor;
        this.inUnit = this.select!.value;
        if ("value" in before && before.text !== this.input.value.trim()) this.value = before.value * factor;
    }
}

/** Puts a set-point into the form, as if it had been typed. */
export function offerSetPoint(setPoint: SetPoint): void {
    byId("drive", HTMLFormElement).dispatchEvent(new CustomEvent<SetPoint>("set-point", { detail: setPoint }));
}

const silent = ["idle", "tripped", "finishing"];

function note(state: State): string {
    if (silent.includes(state.session.state)) return "";
    return state.drive.locked ? "✓ The base follows the drive." : "… The base does not follow the drive yet.";
}

/** The edited fields, as they are sent and in words: "0.5 g, 180 deg". */
export interface Edits { body: Body; words: string }

export interface DriveForm {
    show(state: State): void;
    edits(): Edits | Refused;
    /** The edits have been accepted. */
    accepted(): void;
    /** `changed` is called after each edit. */
    onEdit(changed: () => void): void;
}

export function makeDriveForm(act: Actions, store: Store): DriveForm {
    const form = byId("drive", HTMLFormElement), revert = byId("drive-revert", HTMLButtonElement);
    const noteLine = byId("drive-note", HTMLElement), set = byId("drive-set", HTMLButtonElement);
    const fields = [
        new Field("frequency_hz", "frequency", "Hz"), new Field("gamma_mps2", "gamma", ""), new Field("rho", "rho", ""),
        new Field("phi_rad", "phi", ""),
    ];
    let changed = (): void => undefined;
    const edited = (): Field[] => fields.filter((field) => field.edited);
    const edits = (): Edits | Refused => {
        const body: Body = {}, words: string[] = [];
        for (const { key, typed } of edited()) {
            if ("refused" in typed) return typed;
            body[key] = typed.text;
            words.push(typed.words);
        }
        return { body, words: words.join(", ") };
    };
    const showNote = (): void => {
        const sent = edits(), calm = store.state ? note(store.state) : "";
        showSent(form, noteLine, "refused" in sent ? sent : sent.words ? `will be sent: ${sent.words}` : calm);
        revert.disabled = edited().length === 0;
        changed();
    };
    const follow = (drive: Drive): void => {
        for (const field of fields) if (!field.edited) field.value = drive[field.key];
    };
    const forget = (): void => {
        for (const field of fields) field.mark(false);
        if (store.state) follow(store.state.drive);
        showNote();
    };
    for (const field of fields)
        field.input.addEventListener("input", () => {
            field.mark(true);
            showNote();
        });
    form.addEventListener("change", showNote);  // of a unit
    revert.addEventListener("click", forget);
    form.addEventListener("set-point", (event) => {
        const offered = (event as CustomEvent<SetPoint>).detail;
        for (const field of fields) {
            field.value = offered[field.key];
            field.mark(offered[field.key] !== null);
        }
        if (store.state) follow(store.state.drive);
        showNote();
        form.scrollIntoView({ block: "nearest" });
    });
    // Unchanged, the whole drive is asked for: that is how one arms at what is shown.
    const shown = (): Body => Object.fromEntries(fields.flatMap(({ key }) => (store.state && store.state.drive[key] !== null ? [[key, store.state.drive[key]]] : [])));
    const accepted = (): void => { for (const field of fields) field.mark(false); };
    const body = (): Body | Refused => {
        const sent = edits();
        return "refused" in sent ? sent : sent.words ? sent.body : shown();
    };
    wire(form, act, body, accepted);
    return {
        show: (state) => {
            follow(state.drive);
            setText(set, silent.includes(state.session.state) ? "Set and arm" : "Set the drive");
            showNote();
        },
        edits,
        accepted,
        onEdit: (told) => { changed = told; },
    };
}
