// The form with the four numbers of the drive. A field shows the daemon's value until it is edited; only edited fields
// are sent.
import type { Actions } from "../actions";
import { byId, setText } from "../dom";
import { paperG } from "../groups";
import type { Drive, SetPoint, State } from "../protocol";
import type { Store } from "../store";
import { wire } from "./form";

type Key = "frequency_hz" | "gamma_mps2" | "rho" | "phi_rad";

const units: Record<string, number> = { g: paperG, mps2: 1, deg: Math.PI / 180, rad: 1 };

class Field {
    readonly input: HTMLInputElement;
    private readonly unit: HTMLSelectElement | null;
    private inUnit: string;
    edited = false;

    constructor(readonly key: Key, readonly name: string) {
        this.input = byId(`drive-${name}`, HTMLInputElement);
        const unit = document.getElementById(`drive-${name}-unit`);
        this.unit = unit instanceof HTMLSelectElement ? unit : null;
        this.inUnit = this.unit?.value ?? "";
        this.unit?.addEventListener("change", () => this.convert());
    }

    /** SI; null when it is not a number. */
    get value(): number | null {
        const { value } = this.input;
        return value.trim() === "" || !Number.isFinite(Number(value)) ? null : Number(value) * this.factor;
    }

    set value(si: number | null) {
        const text = si === null ? "" : String(Number((si / this.factor).toPrecision(9)));
        if (this.input.value !== text) this.input.value = text;
    }

    mark(edited: boolean): void {
        this.edited = edited;
        this.input.classList.toggle("edited", edited);
    }

    private get factor(): number { return units[this.inUnit] ?? 1; }

    private convert(): void {
        const si = this.value;
        this.inUnit = this.unit!.value;
        this.value = si;
    }
}

/** Puts a set-point into the form, as if it had been typed. */
export function offerSetPoint(setPoint: SetPoint): void {
    byId("drive", HTMLFormElement).dispatchEvent(new CustomEvent<SetPoint>("set-point", { detail: setPoint }));
}

function note(state: State, edited: boolean): string {
    if (edited) return "Edited fields have a thick border and are not sent yet.";
    if (["idle", "tripped", "finishing"].includes(state.session.state)) return "";
    return state.drive.locked ? "✓ The base follows the drive." : "… The base does not follow the drive yet.";
}

/** Returns what shows a state, and then whether a field is edited. */
export function makeDriveForm(act: Actions, store: Store): (state: State) => boolean {
    const form = byId("drive", HTMLFormElement), revert = byId("drive-revert", HTMLButtonElement);
    const noteLine = byId("drive-note", HTMLElement), set = byId("drive-set", HTMLButtonElement);
    const fields = [
        new Field("frequency_hz", "frequency"), new Field("gamma_mps2", "gamma"), new Field("rho", "rho"),
        new Field("phi_rad", "phi"),
    ];
    const edited = (): boolean => fields.some((field) => field.edited);
    const follow = (drive: Drive): void => {
        for (const field of fields) if (!field.edited) field.value = drive[field.key];
        revert.disabled = !edited();
    };
    const forget = (): void => {
        for (const field of fields) field.mark(false);
        if (store.state) follow(store.state.drive);
    };
    for (const field of fields)
        field.input.addEventListener("input", () => {
            field.mark(true);
            revert.disabled = false;
        });
    revert.addEventListener("click", forget);
    form.addEventListener("set-point", (event) => {
        const offered = (event as CustomEvent<SetPoint>).detail;
        for (const field of fields) {
            field.value = offered[field.key];
            field.mark(offered[field.key] !== null);
        }
        if (store.state) follow(store.state.drive);
        form.scrollIntoView({ block: "nearest" });
    });
    const body = (): Record<string, unknown> | { refused: string } => {
        const wrong = fields.find((field) => field.edited && field.value === null);
        if (wrong) return { refused: `${wrong.name}: a number is needed` };
        // Unchanged, the whole drive is asked for: that is how one arms at what is shown.
        const sent = edited() ? fields.filter((field) => field.edited) : fields.filter((field) => field.value !== null);
        return Object.fromEntries(sent.map((field) => [field.key, field.value]));
    };
    wire(form, act, body, () => { for (const field of fields) field.mark(false); });
    return (state) => {
        follow(state.drive);
        setText(set, ["idle", "tripped", "finishing"].includes(state.session.state) ? "Set and arm" : "Set the drive");
        setText(noteLine, note(state, edited()));
        return edited();
    };
}
