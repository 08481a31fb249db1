// Elements of index.html, and functions that change them only when the content differs.

export function byId<T extends HTMLElement>(id: string, kind: new () => T): T {
    const element = document.getElementById(id);
    if (!(element instanceof kind)) throw new Error(`index.html has no ${kind.name} #${id}`);
    return element;
}

export function setText(node: Node, text: string): void {
    if (node.textContent !== text) node.textContent = text;
}

export function setHidden(element: HTMLElement, hidden: boolean): void {
    if (element.hidden !== hidden) element.hidden = hidden;
}

export function setData(element: HTMLElement, name: string, value: string): void {
    if (element.dataset[name] !== value) element.dataset[name] = value;
}

export function make<K extends keyof HTMLElementTagNameMap>(
    tag: K, className = "", text = "",
): HTMLElementTagNameMap[K] {
    const element = document.createElement(tag);
    if (className) element.className = className;
    if (text) element.textContent = text;
    return element;
}

/** Sets the rows of a table body. Only changed cells are written. The first cell of a row is a heading. */
export function setRows(body: HTMLTableSectionElement, rows: string[][]): void {
    while (body.rows.length > rows.length) body.deleteRow(-1);
    rows.forEach((texts, r) => {
        const row = body.rows[r] ?? body.insertRow();
        while (row.cells.length < texts.length) {
            const cell = make(row.cells.length === 0 ? "th" : "td");
            if (cell.tagName === "TH") cell.setAttribute("scope", "row");
            row.append(cell);
        }
        texts.forEach((text, c) => setText(row.cells[c]!, text));
    });
}
