({ places, rows, pulses, cells }) => cells.map((cell) => {
    const form = formOf(places, Float64Array.from(rows[cell.device]));
    const known = pulses[cell.pulse];
    const pulse = { ...known, pieces: Float64Array.from(known.pieces) };
    const course = follow(form, pulse, cell, cell.end, cell.dt);
    for (;;) {
        const { done, value } = course.next();
        if (done) return value;
    }
})
