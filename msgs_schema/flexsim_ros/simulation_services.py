"""The standard's services (simulation_interfaces) of one simulator, under its node's own name."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import Future
from typing import Any, Protocol

from rclpy.action import ActionServer, CancelResponse
from rclpy.node import Node
from rclpy.task import Future as RosFuture
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import (
    EntityCategory,
    EntityInfo,
    EntityState,
    Result,
    SimulationState,
    SimulatorFeatures,
)
from simulation_interfaces.srv import (
    GetEntities,
    GetEntitiesStates,
    GetEntityInfo,
    GetEntityState,
    GetSimulationState,
    GetSimulatorFeatures,
    ResetSimulation,
    SetSimulationState,
    StepSimulation,
)

from .entities import Entity, FilterRefused, selected
from .extended_regex import RegexError

STOPPED, PLAYING, PAUSED, QUITTING = (
    SimulationState.STATE_STOPPED,
    SimulationState.STATE_PLAYING,
    SimulationState.STATE_PAUSED,
    SimulationState.STATE_QUITTING,
)
WORDS = {STOPPED: "stopped", PLAYING: "playing", PAUSED: "paused", QUITTING: "quitting"}
OK, NOT_FOUND, FAILED = Result.RESULT_OK, Result.RESULT_NOT_FOUND, Result.RESULT_OPERATION_FAILED
# s that an action's result is kept for who did not wait for it.  Each status tells of all that are kept: with
# rclpy's quarter of an hour a flood of goals takes ever longer.
RESULT_KEPT = 10
FEATURES = (
    SimulatorFeatures.ENTITY_TAGS,
    SimulatorFeatures.ENTITY_CATEGORIES,
    SimulatorFeatures.ENTITY_STATE_GETTING,
    SimulatorFeatures.ENTITY_INFO_GETTING,
    SimulatorFeatures.SIMULATION_RESET,
    SimulatorFeatures.SIMULATION_RESET_TIME,
    SimulatorFeatures.SIMULATION_RESET_STATE,
    SimulatorFeatures.SIMULATION_STATE_GETTING,
    SimulatorFeatures.SIMULATION_STATE_SETTING,
    SimulatorFeatures.SIMULATION_STATE_PAUSE,
    SimulatorFeatures.STEP_SIMULATION_SINGLE,
    SimulatorFeatures.STEP_SIMULATION_MULTIPLE,
    SimulatorFeatures.STEP_SIMULATION_ACTION,
)
SCOPE_TIME, SCOPE_STATE = ResetSimulation.Request.SCOPE_TIME, ResetSimulation.Request.SCOPE_STATE
SCOPES = {
    ResetSimulation.Request.SCOPE_DEFAULT: SCOPE_TIME | SCOPE_STATE,
    ResetSimulation.Request.SCOPE_ALL: SCOPE_TIME | SCOPE_STATE,
}


class Simulator(Protocol):
    """A stepping loop in a thread of its own; each future is done when the thread has obeyed."""

    @property
    def trouble(self) -> str:
        """Why time can't go on until a reset, or nothing."""

    @property
    def hindrance(self) -> str:
        """Why steps can't be taken now, or nothing."""

    @property
    def shortage(self) -> str:
        """Why fewer steps were taken than were asked for the last time, or nothing."""

    def pause(self) -> Future[None]:
        """Let time stand still."""

    def resume(self) -> Future[None]:
        """Let time go on."""

    def reset(self, *, time: bool, state: bool) -> Future[None]:
        """Begin time anew, or return to the first state, or both."""

    def step(self, count: int, progress: Callable[[int], bool]) -> Future[int]:
        """Take steps while paused; how many there were.

        Whatever else is asked of the loop ends them early, and so does `progress`, which gets how many
        are done and says whether to go on.
        """


class SimulationServices:
    """Offers the services and the action on a node.

    Parameters
    ----------
    entity_states : what all entities do now, by name
    custom_info : for people, beside the features
    on_reset : called after the loop was asked to return to its first state

    Attributes
    ----------
    state : of the simulation, a constant of simulation_interfaces/SimulationState
    quit_asked : whether someone asked the process to end
    """

    def __init__(
        self,
        node: Node,
        simulator: Simulator,
        entities: Iterable[Entity],
        entity_states: Callable[[], dict[str, EntityState]],
        custom_info: str,
        on_reset: Callable[[], None] = lambda: None,
    ) -> None:
        self.node = node
        self.simulator = simulator
        self.entities = {entity.name: entity for entity in entities}
        self.entity_states = entity_states
        self.custom_info = custom_info
        self.on_reset = on_reset
        self.state: int = PLAYING
        self.quit_asked = False
        for kind, callback in (
            (GetSimulatorFeatures, self._get_features),
            (GetSimulationState, self._get_state),
            (SetSimulationState, self._set_state),
            (ResetSimulation, self._reset),
            (StepSimulation, self._step),
            (GetEntities, self._get_entities),
            (GetEntitiesStates, self._get_entities_states),
            (GetEntityInfo, self._get_entity_info),
            (GetEntityState, self._get_entity_state),
        ):
            self._serve(kind, callback)
        self._action = ActionServer(
            node,
            SimulateSteps,
            "~/simulate_steps",
            self._simulate_steps,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            result_timeout=RESULT_KEPT,
        )

    def close(self) -> None:
        """End the action, which its node does not end."""
        self._action.destroy()

    def _serve(self, kind: Any, callback: Callable[[Any, Any], Any]) -> None:
        name = "".join(f"_{c.lower()}" if c.isupper() else c for c in kind.__name__)

        def obey(request: Any, response: Any) -> Any:
            try:
                return callback(request, response)
            except Exception as problem:
                if hasattr(response, "result"):
                    response.result = result(FAILED, f"it failed: {problem}")
                return response

        service = self.node.create_service(kind, f"~/{name[1:]}", obey)
        send = service.send_response

        def answer(response: Any, header: Any) -> None:
            # An answer that takes time comes when it is there, so that the node hears on.  It is not sent
            # from the stepping thread, which would wait for a client that is gone.
            if isinstance(response, Future):
                response.add_done_callback(lambda done: later(send, done.result(), header))
            else:
                send(response, header)

        def later(*words: Any) -> None:
            executor = self.node.executor
            if executor is not None:  # else the process has ended
                executor.create_task(*words)

        service.send_response = answer  # type: ignore[method-assign]

    def _get_features(self, _: Any, response: Any) -> Any:
        response.features.features = [int(feature) for feature in FEATURES]
        response.features.custom_info = self.custom_info
        return response

    def _get_state(self, _: Any, response: Any) -> Any:
        response.state.state = self.state
        trouble = self.simulator.trouble
        response.result = result(OK, f"time stands still: {trouble}" if trouble else "")
        return response

    def _set_state(self, request: Any, response: Any) -> Any:
        target = request.state.state
        codes = SetSimulationState.Response
        if target not in WORDS:
            choice = ", ".join(f"{number} ({word})" for number, word in WORDS.items())
            response.result = result(Result.RESULT_FEATURE_UNSUPPORTED, f"no state {target}; give {choice}")
        elif target == PLAYING and self.simulator.trouble:
            response.result = result(
                codes.STATE_TRANSITION_ERROR, f"{self.simulator.trouble}; reset it first"
            )
        elif target == self.state:
            response.result = result(codes.ALREADY_IN_TARGET_STATE, f"it is {WORDS[target]}")
        elif target == PAUSED and self.state == STOPPED:
            response.result = result(
                codes.INCORRECT_TRANSITION,
                "it is stopped, where time stands already; step it, or play it and pause then",
            )
        elif target == QUITTING:
            self.state = target
            response.result = result(OK)
            self.simulator.pause()
            self.quit_asked = True
        else:
            if target == PLAYING:
                waiting = [self.simulator.resume()]
            elif target == PAUSED:
                waiting = [self.simulator.pause()]
            else:
                waiting = [self.simulator.pause(), self.simulator.reset(time=True, state=True)]
                self.on_reset()
            self.state = target
            return answered(waiting[-1], response, lambda _: result(OK))
        return response

    def _reset(self, request: Any, response: Any) -> Any:
        scope = SCOPES.get(request.scope, request.scope)
        if scope & ~(SCOPE_TIME | SCOPE_STATE):
            response.result = result(
                Result.RESULT_FEATURE_UNSUPPORTED,
                f"scope is {request.scope}; give 1 (time), 2 (state), 3 (both) or 0 (all there is)",
            )
            return response
        done = self.simulator.reset(time=bool(scope & SCOPE_TIME), state=bool(scope & SCOPE_STATE))
        if scope & SCOPE_STATE:
            self.on_reset()
        return answered(done, response, lambda _: result(OK))

    def _step(self, request: Any, response: Any) -> Any:
        refusal = self._no_steps()
        if refusal:
            response.result = result(FAILED, refusal)
            return response
        self.state = PAUSED
        done = self.simulator.step(request.steps, lambda _: True)
        return answered(done, response, lambda taken: self._stepped(taken, request.steps))

    def _no_steps(self) -> str:
        """Why steps can't be taken, or nothing."""
        if self.state not in (PAUSED, STOPPED):
            return f"it is {WORDS[self.state]}; pause it before you step"
        return self.simulator.hindrance

    def _stepped(self, taken: int, asked: int) -> Result:
        if taken == asked:
            return result(OK)
        why = self.simulator.shortage or "something else was asked of it"
        return result(FAILED, f"{taken} of {asked} steps are done: {why}")

    async def _simulate_steps(self, goal: Any) -> Any:
        answer = SimulateSteps.Result()
        asked = goal.request.steps
        refusal = self._no_steps()
        if refusal:
            answer.result = result(FAILED, refusal)
            goal.abort()
            return answer
        self.state = PAUSED

        def progress(done: int) -> bool:
            goal.publish_feedback(SimulateSteps.Feedback(completed_steps=done, remaining_steps=asked - done))
            return not goal.is_cancel_requested

        executor = self.node.executor
        waited: RosFuture = RosFuture(executor=executor)
        self.simulator.step(asked, progress).add_done_callback(lambda f: waited.set_result(f))
        try:
            taken = (await waited).result()
            answer.result = self._stepped(taken, asked)
        except Exception as problem:
            taken, answer.result = -1, result(FAILED, str(problem))
        if taken == asked:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return answer

    def _get_entities(self, request: Any, response: Any) -> Any:
        found = self._filtered(request, response)
        response.entities = [entity.name for entity in found]
        return response

    def _get_entities_states(self, request: Any, response: Any) -> Any:
        found = self._filtered(request, response)
        states = self.entity_states() if found else {}
        response.entities = [entity.name for entity in found]
        response.states = [states[entity.name] for entity in found]
        return response

    def _filtered(self, request: Any, response: Any) -> list[Entity]:
        response.result = result(OK)
        try:
            return selected(self.entities.values(), request.filters)
        except FilterRefused as problem:
            response.result = result(Result.RESULT_FEATURE_UNSUPPORTED, str(problem))
        except RegexError as problem:
            response.result = result(FAILED, f"filter: {problem}")
        return []

    def _get_entity_info(self, request: Any, response: Any) -> Any:
        response.result = self._found(request.entity)
        if response.result.result == OK:
            entity = self.entities[request.entity]
            response.info = EntityInfo(
                category=EntityCategory(category=entity.category),
                description=entity.description,
                tags=list(entity.tags),
            )
        return response

    def _get_entity_state(self, request: Any, response: Any) -> Any:
        response.result = self._found(request.entity)
        if response.result.result == OK:
            response.state = self.entity_states()[request.entity]
        return response

    def _found(self, name: str) -> Result:
        if name in self.entities:
            return result(OK)
        return result(NOT_FOUND, f"no entity {name!r}; there are {', '.join(self.entities)}")


def answered(done: Future[Any], response: Any, say: Callable[[Any], Result]) -> Future[Any]:
    """The response, once the simulator has obeyed."""
    answer: Future[Any] = Future()

    def finish(obeyed: Future[Any]) -> None:
        try:
            response.result = say(obeyed.result())
        except Exception as problem:
            response.result = result(FAILED, str(problem))
        answer.set_result(response)

    done.add_done_callback(finish)
    return answer


def result(code: int, sentence: str = "") -> Result:
    """How a request ended."""
    return Result(result=code, error_message=sentence)
