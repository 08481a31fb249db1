// Colours of the plots: the CSS custom properties of style.css, read once for each theme.

const names = [
    "text", "faint", "grid", "target", "measured", "walker", "base", "closed", "limit",
    "series-1", "series-2", "series-3", "series-4", "series-5", "series-6",
] as const;
export type Colour = (typeof names)[number];
export type Theme = Record<Colour, string>;

const key = "shakerd-theme";
const choices = ["auto", "light", "dark"] as const;
type Choice = (typeof choices)[number];
const words: Record<Choice, string> = { auto: "Theme: auto", light: "Theme: light", dark: "Theme: dark" };

export class Themes {
    current: Theme;
    /** Incremented by each change of the colours. */
    version = 0;
    private choice: Choice;
    private readonly prefersDark = matchMedia("(prefers-color-scheme: dark)");

    constructor(private readonly button: HTMLButtonElement) {
        const stored = localStorage.getItem(key) as Choice | null;
        this.choice = stored && choices.includes(stored) ? stored : "auto";
        this.current = this.apply();
        this.prefersDark.addEventListener("change", () => { this.current = this.apply(); });
        button.addEventListener("click", () => {
            this.choice = choices[(choices.indexOf(this.choice) + 1) % choices.length]!;
            localStorage.setItem(key, this.choice);
            this.current = this.apply();
        });
    }

    private apply(): Theme {
        const automatic = this.prefersDark.matches ? "dark" : "light";
        document.documentElement.dataset["theme"] = this.choice === "auto" ? automatic : this.choice;
        this.button.textContent = words[this.choice];
        this.version++;
        const style = getComputedStyle(document.documentElement);
        return Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()])) as Theme;
    }
}
