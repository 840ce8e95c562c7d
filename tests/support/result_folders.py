"""Result folders as an analysis would leave them."""

from pathlib import Path

from fingerdesign.records.result_files import RESULTS, write_result_files


def write_result_folder(target, result, grip_traces=(), texts=None) -> Path:
    """result.json, history.csv, grip_*.csv and other texts by their file names; the folder."""
    with RESULTS.written(target) as folder:
        for name, text in (texts or {}).items():
            (folder / name).write_text(text, encoding="utf-8")
        write_result_files(folder, result, grip_traces)
    return Path(target)
