# The page that shows it all.


rule report:
    input:
        dataset=rules.dataset.output,
        figures=rules.figures.output,
        claims=rules.claims.output.json,
    output:
        report(
            f"{RESULTS}/report.html",
            caption="../report/report.rst",
            category="Report",
        ),
    log:
        f"{RESULTS}/logs/report.log",
    benchmark:
        f"{RESULTS}/benchmarks/report.tsv"
    conda:
        "../envs/talus.yaml"
    resources:
        **READING,
    params:
        # No input: its path may hold braces, which are no wildcards, and must not matter.
        study=files_hash(STUDY.files),
        code=room("report"),
    shell:
        'python -m sim report "$TALUS_STUDY" > {log} 2>&1'
