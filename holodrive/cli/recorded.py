"""A recorded run and its wheel odometry as a row of a table and as a section of a page."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from holodrive.estimation import Evaluation
    from holodrive.log.recording import Recording
    from holodrive.reports.sections import RecordingSection

FIGURES = ("path_length_m", "end_error_m", "max_error_m", "rmse_m", "heading_error_rad")


def evaluation_row(evaluation: "Evaluation") -> dict[str, Any]:
    """Name and figures."""
    row = {"name": evaluation.name, "family": evaluation.family, "robot": evaluation.robot}
    return row | {name: getattr(evaluation, name) for name in FIGURES} | {"refused": evaluation.counts.refused}


def section(recording: "Recording", evaluation: "Evaluation") -> "RecordingSection":
    """Truth and odometry on the floor, and the error over time."""
    from holodrive.reports.sections import RecordingSection

    seconds = float(evaluation.time[-1] - evaluation.time[0])
    facts = {"robot": evaluation.robot, "samples": str(len(evaluation.time)), "duration": f"{seconds:.1f} s"}
    source = f"{recording.source} ({recording.licence})" if recording.licence else recording.source
    return RecordingSection(
        title=f"Recorded: {recording.name}",
        time=evaluation.time - evaluation.time[0],
        odometry=evaluation.pose,
        truth=evaluation.truth,
        metrics={name: getattr(evaluation, name) for name in FIGURES},
        note=f"Exact odometry from the encoders alone, with the geometry of the robot's file. {source}",
        facts=facts,
    )
