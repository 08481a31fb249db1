// The regions in which targets are searched, moved by the operator over the live pictures: with the pointer, or a focused
// box with the arrow keys. One order sends all changed regions.
import type { Actions } from "../actions";
import { byId, make, setHidden, setText } from "../dom";
import type { Camera, Region, State } from "../protocol";
import type { Store } from "../store";
import { wire } from "./form";

const least = 4;  // px, of a side
const atRest = new Set(["idle", "armed", "tripped"]);

interface Size { width: number; height: number }
export interface MovedTarget { camera: string; target: string; region_px: Region }

const within = (value: number, low: number, high: number): number => Math.round(Math.max(low, Math.min(high, value)));

/** The region moved in the picture. */
export function shifted([x, y, width, height]: Region, dx: number, dy: number, size: Size): Region {
    return [within(x + dx, 0, Math.max(0, size.width - width)), within(y + dy, 0, Math.max(0, size.height - height)), width, height];
}

/** The region with its lower right corner moved in the picture. */
export function resized([x, y, width, height]: Region, dx: number, dy: number, size: Size): Region {
    return [x, y, within(width + dx, least, Math.max(least, size.width - x)), within(height + dy, least, Math.max(least, size.height - y))];
}

/** The lines of the rig file for regions; a rig file counts px in the uncropped picture. */
export function rigLines(moved: MovedTarget[], cameras: Pick<Camera, "name" | "origin_px">[]): string {
    return moved.map(({ camera, target, region_px: [x, y, width, height] }) => {
        const [right, down] = cameras.find(({ name }) => name === camera)?.origin_px ?? [0, 0];
        return `# [[camera]] name = "${camera}", [[camera.target]] name = "${target}"\nroi_px = [${x + right}, ${y + down}, ${width}, ${height}]`;
    }).join("\n");
}

class Box {
    readonly element = make("button");
    private readonly words = make("span");
    changed = false;

    constructor(readonly target: string, private region_px: Region, private readonly size: Size) {
        const corner = make("i");
        this.element.type = "button";
        this.element.className = "target-box";
        this.element.dataset["kind"] = target;
        this.element.setAttribute("aria-describedby", "targets-note");
        this.element.append(this.words, corner);
        this.element.addEventListener("keydown", (event) => this.key(event));
        this.drag(this.element, shifted);
        this.drag(corner, resized);
        this.place();
    }

    get region(): Region { return this.region_px; }

    /** A proposal is dashed until the operator moves it. */
    take(region: Region, proposed: boolean): void {
        if (region.join() !== this.region_px.join()) this.changed = true;
        this.region_px = region;
        this.element.classList.toggle("proposed", proposed);
        this.place();
    }

    private place(): void {
        const [x, y, width, height] = this.region_px, { style } = this.element;
        style.left = `${(100 * x) / this.size.width}%`;
        style.top = `${(100 * y) / this.size.height}%`;
        style.width = `${(100 * width) / this.size.width}%`;
        style.height = `${(100 * height) / this.size.height}%`;
        setText(this.words, `${this.target} ${x}, ${y}, ${width} × ${height} px`);
    }

    private key(event: KeyboardEvent): void {
        const step = ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] } as Record<string, [number, number]>)[event.key];
        if (!step) return;
        event.preventDefault();
        this.take((event.shiftKey ? resized : shifted)(this.region_px, step[0], step[1], this.size), false);
    }

    private drag(handle: HTMLElement, change: typeof shifted): void {
        let from: { x: number; y: number; region: Region; pxPerCss: number } | null = null;
        handle.addEventListener("pointerdown", (event) => {
            event.stopPropagation();
            handle.setPointerCapture(event.pointerId);
            this.element.focus();
            from = { x: event.clientX, y: event.clientY, region: this.region_px, pxPerCss: this.size.width / this.element.parentElement!.clientWidth };
        });
        handle.addEventListener("pointermove", ({ clientX, clientY }) => {
            if (from) this.take(change(from.region, (clientX - from.x) * from.pxPerCss, (clientY - from.y) * from.pxPerCss, this.size), false);
        });
        for (const end of ["pointerup", "pointercancel"]) handle.addEventListener(end, () => { from = null; });
    }
}

/** The boxes over the picture of one camera. Empty unless open. */
export class RegionLayer {
    readonly element = make("div", "regions");
    private boxes: Box[] = [];

    open(camera: Camera): void {
        if (!camera.width_px || !camera.height_px) return;
        const size = { width: camera.width_px, height: camera.height_px }, area = ([, , width, height]: Region): number => width * height;
        this.boxes = camera.targets.map(({ name, region_px }) => new Box(name, region_px, size));
        // Small boxes lie above large ones.
        this.element.replaceChildren(...[...this.boxes].sort((a, b) => area(b.region) - area(a.region)).map((box) => box.element));
    }

    close(): void {
        this.boxes = [];
        this.element.replaceChildren();
    }

    /** Takes the daemon's proposals. Returns the targets without one. */
    propose(camera: Camera): string[] {
        return camera.targets.flatMap(({ name, proposed_px }) => {
            if (!proposed_px) return [`${name} of camera ${camera.name}`];
            this.boxes.find(({ target }) => target === name)?.take(proposed_px, true);
            return [];
        });
    }

    moved(camera: string): MovedTarget[] {
        return this.boxes.filter(({ changed }) => changed).map(({ target, region }) => ({ camera, target, region_px: region }));
    }
}

/** The buttons below the pictures. layers: in the order of the state's cameras. */
export function makeTargetRegions(act: Actions, store: Store, layers: () => RegionLayer[]): () => void {
    const button = (id: string): HTMLButtonElement => byId(id, HTMLButtonElement);
    const move = button("targets-move"), use = button("targets-use"), propose = button("targets-propose"), cancel = button("targets-cancel");
    const note = byId("targets-note", HTMLElement), kept = byId("targets-kept", HTMLElement), lines = byId("targets-lines", HTMLElement);
    const advice = note.textContent ?? "";
    let sent: MovedTarget[] = [];
    const each = <T>(work: (layer: RegionLayer, camera: Camera) => T): T[] =>
        layers().flatMap((layer, k) => { const camera = store.state?.cameras[k]; return camera ? [work(layer, camera)] : []; });
    const show = (open: boolean): void => {
        for (const element of [use, propose, cancel, note]) setHidden(element, !open);
        setHidden(move, open);
        setText(note, advice);
        if (open) setHidden(kept, true);
        if (!open) for (const layer of layers()) layer.close();
    };
    move.addEventListener("click", () => {
        show(true);
        each((layer, camera) => layer.open(camera));
    });
    cancel.addEventListener("click", () => { show(false); move.focus(); });
    propose.addEventListener("click", () => {
        const missing = each((layer, camera) => layer.propose(camera)).flat();
        setText(note, missing.length === 0 ? "Proposed: the present place of each target. Use these regions, or move them first."
            : `Not found in the picture: ${missing.join(", ")}. Move the region onto the target.`);
    });
    wire(byId("targets", HTMLFormElement), act, () => {
        sent = each((layer, camera) => layer.moved(camera.name)).flat();
        return sent.length ? { targets: sent } : { refused: "no region was moved" };
    }, () => {
        show(false);
        const simulated = store.state?.session.simulated ?? false;
        setText(kept.firstElementChild!, simulated ? "The regions are in force until the daemon ends. A simulated bench places its own at the next start."
            : "The regions are in force until the daemon ends. To keep them, put these lines into the rig file; a changed rig file needs a new commissioning.");
        setText(lines, simulated ? "" : rigLines(sent, store.state?.cameras ?? []));
        setHidden(lines, simulated);
        setHidden(kept, false);
    });
    return () => {
        const rest = restOf(store.state);
        move.disabled = !rest;
        if (!rest && move.hidden) show(false);
    };
}

function restOf(state: State | null): boolean {
    return state !== null && atRest.has(state.session.state) && !state.campaign?.active && state.cameras.some(({ height_px }) => height_px);
}
