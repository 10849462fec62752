"""What a run leaves at its end: program, folded form, crease pattern, checkpoints."""

from folding_schemas.results import CheckpointState, Export, ExportFormat, RunInfo

from folding_client.interrupts import ToolRefused
from folding_client.protocol.server_client import ServerClient
from folding_client.record.recorder import Recorder

OUTPUT_FILES: tuple[tuple[str, ExportFormat], ...] = (
    ("final.fold", "fold"),
    ("crease_pattern.fold", "crease-pattern"),
    ("crease_pattern.svg", "crease-pattern-svg"),
)


async def write_outputs(server: ServerClient, recorder: Recorder, info: RunInfo) -> list[str]:
    """Write the results of what is saved so far; the names of the files. A file the server cannot make is
    recorded.
    """
    recorder.folder.write_json(
        "checkpoints.json",
        [
            (await server.ask(CheckpointState, "get_checkpoint_state", frame=frame))[0].model_dump(
                mode="json"
            )
            for frame in info.saved
        ],
    )
    recorder.folder.write_json("program.json", info.program.model_dump(mode="json", exclude_none=True))
    return [
        "program.json",
        "checkpoints.json",
        *[name for name, kind in OUTPUT_FILES if await _export(server, recorder, name, kind)],
    ]


async def _export(server: ServerClient, recorder: Recorder, name: str, kind: ExportFormat) -> bool:
    try:
        export, _ = await server.ask(Export, "export_state", format=kind)
    except ToolRefused as refusal:
        recorder.event("output_missing", file=name, reason=str(refusal))
        return False
    recorder.folder.write_text(name, export.text or "")
    return True
