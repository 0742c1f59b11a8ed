// Where in the window the cell of the i-th x and the j-th y is drawn.
([i, j]) => {
    const { xaxis, yaxis } = map._fullLayout;
    const box = map.querySelector(".nsewdrag").getBoundingClientRect();
    const [x, y] = [axes[X].values[i], axes[Y].values[j]];
    return [box.x + xaxis.d2p(x), box.y + yaxis.d2p(y)];
}
