studied = provenance.code_hash(*provenance.NUMBERS, clone / "studies")
STUDIES = {"accuracy": ["accuracy"], "stability": ["stability", "settled"]}

for what, stems in STUDIES.items():

    rule:
        name:
            what
        output:
            table=f"results/studies/{what}.csv",
            figures=expand(
                "results/figures/{stem}.{kind}", stem=stems, kind=["pdf", "png"]
            ),
        log:
            f"results/logs/{what}.log",
        # A study takes all cores, as another job at the same time would spoil its times.
        threads: 1000
        params:
            code=studied,
            device=json.dumps(provenance.device_sections(nominal(study.device))),
            python=sys.executable,
            path=os.pathsep.join([str(clone), str(scripts)]),
        message:
            f"Study the {what}"
        shell:
            f"PYTHONPATH={{params.path:q}} {{params.python:q}} -m studies {what} "
            "--device {params.device:q} > {log:q} 2>&1"
