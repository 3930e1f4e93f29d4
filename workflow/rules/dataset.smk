# All runs of the study in one labelled file. It is not marked `update`: if a damaged run prevents
# it, the file must be missing, so that a rerun computes that run again.


rule dataset:
    input:
        lambda wildcards: run_files(STUDY.rounds),
    output:
        f"{RESULTS}/dataset.nc",
    log:
        f"{RESULTS}/logs/dataset.log",
    benchmark:
        f"{RESULTS}/benchmarks/dataset.tsv"
    conda:
        "../envs/talus.yaml"
    threads: max(1, min(len(STUDY.points) // 20, local_cores() or 1))
    resources:
        **PLAN.reader_resources,
    params:
        membership=[(one.id, one.series, one.figures) for one in STUDY.points.values()],
        profiles=[one.id for one in STUDY.points.values() if one.profiles],
        amounts=[amounts(point.parameters) for point in STUDY.points.values()],
        boundaries=as_written(PLAN.boundary_searches),
        states=[name for name, spec in STUDY.entries.items() if spec.keys.particles],
        title=as_written(STUDY.title),
        code=room_code("dataset", "observable"),
    shell:
        'python -m sim job dataset "$TALUS_STUDY" --processes {threads} > {log} 2>&1'
