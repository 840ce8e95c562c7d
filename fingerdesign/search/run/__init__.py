"""Running a study: jobs, evaluation, cluster, store."""
