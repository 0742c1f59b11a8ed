"""The page to explore a study in a browser.  Imports: requirements."""

from ..application import Application, Config, Figures, Files


class Page(Application):
    part = "4 Page"
    saved_in, endings = "results", ("html",)

    def drawn_from(self, study: Config) -> Files:
        """Cube and thresholds, and the verdicts on required shocks."""
        from ..requirements import application as requirements

        cells = {"cube": "results/cube.nc", "threshold": "results/threshold.nc"}
        return {**cells, **requirements.outputs(study)}

    def figures(self, study: Config) -> Figures:
        """The page, with what the cube does not hold."""
        from .. import gather

        marks, start = gather(lambda part: part.marks(study)).values(), study.start
        each = [(shocks.pulse, shocks.direction) for shocks in study.shocks.each()]
        required = [
            (name, f0, N, [(p.name, way) for p, way in each if (p.section, way, start) in pushed])
            for shocks in marks
            for name, f0, N, pushed in shocks
        ]
        shown = {"title": study.title, "pulse": study.shocks.values(), "written": study.written}
        shown |= {"horizon": study.horizon, "required": required}
        return {"explore": shown | {"own_points": list(study.own_points)}}

    def draw(self, figures: Figures, folder: str, files: Files) -> None:
        """Write the page."""
        from ...config.points import read_points
        from ...files.atomic import write_text
        from ...study.variables import open_whole
        from ..requirements.verdict import read_verdicts
        from .figure import page

        verdicts = read_verdicts(files["requirements"]) if "requirements" in files else ()
        with open_whole(files["cube"]) as cube, open_whole(files["threshold"]) as thresholds:
            for name, shown in figures.items():
                own = shown["own_points"]
                points = read_points(*own) if own else ()
                text = page(cube, thresholds, shown, verdicts, points)
                write_text(text, f"{folder}/{name}.html")


application = Page()
