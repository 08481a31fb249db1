// The cameras' pictures with marks on tracked targets. Each camera decodes one picture at a time; later ones wait.
import type { Connection } from "../connection";
import { make, setText } from "../dom";
import { fixed } from "../format";
import type { Mark, PictureFrame } from "../frames";
import type { Loop } from "../loop";
import type { Store } from "../store";

/** Marks on pictures are independent of the theme: light lines with a dark rim. */
const looks: { name: string; colour: string; dash: number[] }[] = [
    { name: "walker", colour: "#e69f00", dash: [] },
    { name: "base", colour: "#56b4e9", dash: [8, 5] },
    { name: "other", colour: "#cc79a7", dash: [2, 4] },
];
const states = ["", "degraded", "lost", "found again"];
const rate = 10;  // Hz

const look = (kind: number) => looks[Math.min(kind & 15, looks.length - 1)]!;

/** `zoom`: CSS px per px of the picture. */
function drawMark(ctx: CanvasRenderingContext2D, mark: Mark, zoom: number): void {
    const { name, colour, dash } = look(mark.kind);
    const trouble = states[(mark.kind >> 4) & 3] ?? "";
    const x = mark.x * zoom, y = mark.y * zoom;
    for (const [stroke, width, lines] of [["#000", 4, []], [colour, 2, dash]] as const) {
        ctx.strokeStyle = stroke;
        ctx.lineWidth = width;
        ctx.setLineDash(lines);
        ctx.strokeRect(x, y, mark.width * zoom, mark.height * zoom);
    }
    ctx.setLineDash([]);
    ctx.font = "12px system-ui, sans-serif";
    ctx.lineWidth = 3;
    ctx.strokeStyle = "#000";
    ctx.fillStyle = colour;
    const words = trouble ? `${name}: ${trouble}` : name;
    const baseline = y > 16 ? y - 5 : y + 14;
    ctx.strokeText(words, x + 2, baseline);
    ctx.fillText(words, x + 2, baseline);
}

function describe(name: string, frame: PictureFrame): string {
    const seen = frame.marks.map((mark) => `${look(mark.kind).name} ${states[(mark.kind >> 4) & 3] || "tracked"}`);
    return `${name}, ${fixed(frame.t0, 1)} s: ${seen.join(", ") || "no target found"}`;
}

class CameraView {
    readonly figure = make("figure");
    private readonly canvas = make("canvas");
    private readonly caption = make("figcaption");
    private shown: PictureFrame | null = null;
    private decoding = false;

    constructor(private readonly name: string) {
        this.canvas.setAttribute("role", "img");
        this.canvas.setAttribute("aria-label", `Picture of camera ${name} with its tracked targets`);
        this.canvas.width = 640;
        this.canvas.height = 160;
        setText(this.caption, `${name}: no picture yet`);
        this.figure.append(this.canvas, this.caption);
    }

    get pixels(): number { return Math.round(this.canvas.clientWidth * devicePixelRatio); }

    async show(frame: PictureFrame): Promise<void> {
        if (frame === this.shown || this.decoding) return;
        this.decoding = true;
        this.shown = frame;
        try {
            const bitmap = await createImageBitmap(new Blob([frame.jpeg], { type: "image/jpeg" }));
            this.paint(bitmap, frame);
            bitmap.close();  // frees its memory without waiting for the garbage collector
        } catch {
            setText(this.caption, `${this.name}: a picture could not be decoded`);
        } finally {
            this.decoding = false;
        }
    }

    private paint(bitmap: ImageBitmap, frame: PictureFrame): void {
        const { canvas } = this;
        const across = Math.max(1, canvas.clientWidth), zoom = across / bitmap.width, down = bitmap.height * zoom;
        const width = Math.round(across * devicePixelRatio), height = Math.round(down * devicePixelRatio);
        if (canvas.width !== width || canvas.height !== height) {
            canvas.width = width;
            canvas.height = height;
            canvas.style.aspectRatio = `${bitmap.width} / ${bitmap.height}`;
        }
        const ctx = canvas.getContext("2d");
        if (!ctx) return;
        ctx.setTransform(width / across, 0, 0, height / down, 0, 0);
        ctx.drawImage(bitmap, 0, 0, across, down);
        for (const mark of frame.marks) drawMark(ctx, mark, zoom);
        setText(this.caption, describe(this.name, frame));
    }
}

/** Names of the cameras in the table of losses ("camera:top"), in its order; before the first state "top" and "side". */
function cameraNames(store: Store): string[] {
    const named = (store.state?.losses ?? []).flatMap(({ stream }) => /^camera:(.+)$/.exec(stream)?.[1] ?? []);
    return named.length ? named.slice(0, store.pictures.length) : ["top", "side"];
}

export function makeCameras(
    list: HTMLElement, card: HTMLElement, store: Store, connection: Connection, loop: Loop,
): { draw: () => void; subscribe: () => void } {
    let names: string[] = [];
    let views: CameraView[] = [];
    const rebuild = (wanted: string[]): void => {
        for (const name of names) connection.unsubscribe(`camera:${name}`);
        names = wanted;
        views = names.map((name) => new CameraView(name));
        list.replaceChildren(...views.map((view) => view.figure));
    };
    return {
        draw: () => {
            const wanted = cameraNames(store);
            if (wanted.join() !== names.join()) rebuild(wanted);
            views.forEach((view, k) => {
                const frame = store.pictures[k];
                if (frame) void view.show(frame);
            });
        },
        /** Requests pictures only while they are in view, because they need most of the bandwidth. */
        subscribe: () => {
            const watched = !document.hidden && loop.isVisible(card);
            views.forEach((view, k) => {
                const stream = `camera:${names[k]}`;
                if (watched && view.pixels > 0) connection.subscribe(stream, view.pixels, rate);
                else connection.unsubscribe(stream);
            });
        },
    };
}
