"""The general constraint solver (ortools CP-SAT), for parts that our own search does not settle quickly."""

from typing import TYPE_CHECKING

from folding_server.errors import FoldingError
from folding_server.simulator.foldability.orders import Orders, bits

if TYPE_CHECKING:
    from ortools.sat.python import cp_model


def solve(orders: Orders, part: list[int]) -> bool:
    """Decide all classes of a part so that its conditions hold; False, with the orders as they were, if none does.

    FoldingError where OR-Tools is not installed.
    """
    try:
        from ortools.sat.python import cp_model
    except ModuleNotFoundError as error:
        raise FoldingError(
            f"Deciding the order of the layers of this pattern, with {len(part)} questions left that depend on each other, "
            "needs OR-Tools, which is not installed; install it with pip install 'foldingagent-mcp[foldability]'."
        ) from error
    model = cp_model.CpModel()
    variables = {number: model.new_bool_var(str(number)) for number in part}
    _add_parities(model, variables, orders)
    _add_triples(model, variables, orders)
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 2
    solver.parameters.random_seed = 0
    status = solver.solve(model)
    if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        return False
    chosen = {number: bool(solver.value(variable)) for number, variable in variables.items()}
    return all(orders.decide(number, value) for number, value in chosen.items())


def _add_parities(model: "cp_model.CpModel", variables: "dict[int, cp_model.IntVar]", orders: Orders) -> None:
    rows = {k for number in variables for k in orders.equations.watching[number]}
    for k in sorted(rows):
        row, odd = orders.equations.parities[k]
        held = sum(bool(orders.value[other]) for other in row if orders.value[other] is not None)
        left = [variables[other] for other in row if orders.value[other] is None]
        if (held % 2 == 1) == odd:
            left.append(model.new_constant(1))
        model.add_bool_xor(left)


def _add_triples(model: "cp_model.CpModel", variables: "dict[int, cp_model.IntVar]", orders: Orders) -> None:
    """No three faces of one cell lie in a circle."""
    seen = set()
    for number in variables:
        for x, y in orders.equations.members[number]:
            both = orders.cells[x] & orders.cells[y]
            for z in bits(orders.touching[x] & orders.touching[y]):
                triple = tuple(sorted((x, y, z)))
                if triple not in seen and both & orders.cells[z]:
                    seen.add(triple)
                    a, b, c = triple
                    for circle in (((a, b), (b, c), (c, a)), ((b, a), (c, b), (a, c))):
                        _forbid(model, variables, orders, circle)


def _forbid(
    model: "cp_model.CpModel",
    variables: "dict[int, cp_model.IntVar]",
    orders: Orders,
    circle: tuple[tuple[int, int], ...],
) -> None:
    """Not all statements of a circle hold."""
    clause = []
    for x, y in circle:
        number, value = orders.equations.literal(x, y)
        held = orders.value[number]
        if held is None:
            clause.append(~variables[number] if value else variables[number])
        elif held != value:
            return
    model.add_bool_or(clause)
