# What applications make, if the study asks for it; docs/architecture.md has a table. The rules take their
# values from the `__init__.py` of each folder.

for name in slow:
    application = attached()[name]

    rule:
        name:
            application.rule
        input:
            **application.inputs(study),
        output:
            **kept(making[name]),
        log:
            f"results/logs/{application.rule}.log",
        priority: application.priority
        threads: application.threads or half
        resources:
            mem_mb=memory(application.megabytes),
        params:
            code=numbers,
            inputs=in_search,
            request=constant(application.params(study)),
        message:
            application.message
        script:
            "../scripts/jobs.py"


# Drawn in the job of the study are those that need no more files.
at_hand = {"results/cube.nc", "results/threshold.nc", *made_quickly}
read = {name: listed(attached()[name].drawn_from(study)) for name in drawing_of}
drawn_together = [name for name in drawing_of if at_hand.issuperset(read[name])]


for place, name in enumerate(name for name in drawing_of if name not in drawn_together):

    rule:
        name:
            f"draw_{name}"
        input:
            **attached()[name].drawn_from(study),
        output:
            figures_of(name),
        log:
            f"results/logs/draw_{name}.log",
        priority: 83 - place
        group:
            "figures"
        resources:
            runtime=10,
        params:
            figures=constant(drawing_of[name]),
            code=drawing,
        message:
            f"Draw the {name}"
        script:
            "../scripts/draw.py"
