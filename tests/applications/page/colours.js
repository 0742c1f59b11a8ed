// Colours of texts and of what is behind them, without those that a filter turns, or on cells.
() => [...document.querySelectorAll("body *")].filter((element) =>
    element.checkVisibility()
    && !element.closest("#history, figure svg, .scatterlayer, .annotation")
    && [...element.childNodes].some(({ nodeType, data }) => nodeType === 3 && data.trim())
).map((element) => {
    const { color, fill } = getComputedStyle(element);
    const ground = (part) => {
        const { backgroundColor: own } = getComputedStyle(part);
        return own === "rgba(0, 0, 0, 0)" ? ground(part.parentElement) : own;
    };
    return [element.closest("svg") ? fill : color, ground(element)];
})
