"""Models of failure by all factors at once, scored on episodes that they were not fitted to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tabletopgen._media import imported
from tabletopgen.env.sensitivity_table import Table

# Parts that are left out in turn, and how often the division into them is drawn.
PARTS, REPEATS = 5, 3
# A tree that can be read: questions from its root to a leaf, episodes in a leaf as a share, and the impurity that a
# question has to remove.
DEPTH, LEAF_SHARE, PRUNED_BELOW = 3, 0.05, 0.01
# Shuffles of a factor among the episodes of a part that was left out.
FACTOR_SHUFFLES = 10

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Importance:
    """The log loss that shuffling a factor among held-out episodes adds: the mean, and the central 95 % over parts and
    shuffles."""

    name: str
    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class Model:
    """A kind of model: log loss (nats per episode) and area under the ROC curve of episodes it was not fitted to, and
    the importance of each factor, the greatest first."""

    kind: str
    log_loss: float
    auc: float
    importances: tuple[Importance, ...]


@dataclass(frozen=True)
class Models:
    """Models by their kind, the log loss of always predicting the share of failures, the area under the ROC curve of
    the environment alone, and the rules of a tree fitted to all episodes."""

    base_log_loss: float
    environment_auc: float | None
    models: tuple[Model, ...]
    rules: str

    @property
    def best(self) -> Model:
        return min(self.models, key=lambda model: model.log_loss)


def models_of(table: Table, seed: int = 0) -> Models | None:
    """The models of a table; `None` where there are too few failures or successes to leave any out."""
    parts = held_out_parts(table, seed)
    if parts is None or not table.factors:
        return None
    numbers = matrix(table)
    made = {"tree": lambda: tree(table), "logistic": lambda: logistic(table)}
    found = tuple(scored(kind, make, numbers, table, parts, seed) for kind, make in made.items())
    base = np.concatenate([losses(np.full(len(test), table.failed[train].mean()), table.failed[test]) for train, test in parts])
    whole = tree(table).fit(numbers, table.failed)
    rules = imported("sklearn.tree", "scikit-learn").export_text(whole[-1], feature_names=names_of(whole, table), decimals=4)
    return Models(float(base.mean()), environment_auc(table, parts), found, rules)


def held_out_parts(table: Table, seed: int) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]] | None:
    """Places of episodes to fit to and to score. Episodes of one start are in one part."""
    rarest = min(len(np.unique(table.starts[table.failed])), len(np.unique(table.starts[~table.failed])))
    if rarest < PARTS:
        return None
    folds = imported("sklearn.model_selection", "scikit-learn").StratifiedGroupKFold
    drawn = (folds(PARTS, shuffle=True, random_state=seed + repeat) for repeat in range(REPEATS))
    return [pair for one in drawn for pair in one.split(table.failed, table.failed, table.starts)]


def matrix(table: Table) -> Floats:
    """Factors as numbers, (episodes, factors): words as their places in the order of the alphabet."""
    columns = [one.values if one.is_number else np.unique(one.values, return_inverse=True)[1].astype(float) for one in table.factors]
    return np.column_stack(columns)


def prepared(table: Table, *, scaled: bool) -> Any:
    """Brings factors into the form of a model: numbers that are missing as the median, each word as a column."""
    compose, pipeline = imported("sklearn.compose", "scikit-learn"), imported("sklearn.pipeline", "scikit-learn")
    preprocessing, impute = imported("sklearn.preprocessing", "scikit-learn"), imported("sklearn.impute", "scikit-learn")
    are_numbers = [place for place, one in enumerate(table.factors) if one.is_number]
    words = [place for place, one in enumerate(table.factors) if not one.is_number]
    steps = [impute.SimpleImputer(strategy="median", keep_empty_features=True), *([preprocessing.StandardScaler()] if scaled else [])]
    hot = preprocessing.OneHotEncoder(handle_unknown="ignore", sparse_output=False)
    return compose.ColumnTransformer([("numbers", pipeline.make_pipeline(*steps), are_numbers), ("words", hot, words)])


def tree(table: Table) -> Any:
    """A decision tree that is not fitted yet."""
    made, pipeline = imported("sklearn.tree", "scikit-learn").DecisionTreeClassifier, imported("sklearn.pipeline", "scikit-learn")
    shape = {"max_depth": DEPTH, "min_samples_leaf": LEAF_SHARE, "ccp_alpha": PRUNED_BELOW}
    return pipeline.make_pipeline(prepared(table, scaled=False), made(**shape, random_state=0))


def logistic(table: Table) -> Any:
    """A logistic regression that is not fitted yet; numbers are scaled to a spread of 1."""
    made, pipeline = imported("sklearn.linear_model", "scikit-learn").LogisticRegression, imported("sklearn.pipeline", "scikit-learn")
    return pipeline.make_pipeline(prepared(table, scaled=True), made(C=0.3, max_iter=1000))


def names_of(fitted: Any, table: Table) -> list[str]:
    """Names of the columns of a fitted model."""
    names = [one.name for one in table.factors if one.is_number]
    for one in table.factors:
        if not one.is_number:
            names += [f"{one.name} is {value}" for value in np.unique(one.values)]
    assert len(names) == fitted[-1].n_features_in_
    return names


def scored(kind: str, make: Any, numbers: Floats, table: Table, parts: Any, seed: int) -> Model:
    """A kind of model, fitted without each part and scored on it."""
    random = np.random.default_rng(seed)
    score = imported("sklearn.metrics", "scikit-learn").roc_auc_score
    found, areas = [], []
    added: list[list[float]] = [[] for _ in table.factors]
    for train, test in parts:
        model = make().fit(numbers[train], table.failed[train])
        predicted = probability_of_failure(model, numbers[test])
        own = losses(predicted, table.failed[test])
        found.append(own)
        if 0 < table.failed[test].sum() < len(test):
            areas.append(score(table.failed[test], predicted))
        changed = np.tile(numbers[test], (len(table.factors), FACTOR_SHUFFLES, 1, 1))
        for place, copies in enumerate(changed):
            copies[:, :, place] = random.permuted(copies[:, :, place], axis=1)
        again = probability_of_failure(model, changed.reshape(-1, len(table.factors))).reshape(changed.shape[:3])
        for place, more in enumerate((losses(again, table.failed[test]) - own).mean(axis=2)):
            added[place] += more.tolist()
    rows = [
        Importance(one.name, float(np.mean(own)), *np.quantile(own, [0.025, 0.975]).tolist())
        for one, own in zip(table.factors, added, strict=True)
    ]
    return Model(kind, float(np.concatenate(found).mean()), float(np.mean(areas)), tuple(sorted(rows, key=lambda one: -one.mean)))


def probability_of_failure(model: Any, numbers: Floats) -> Floats:
    found: Floats = model.predict_proba(numbers)[:, list(model.classes_).index(True)]
    return found


def losses(predicted: Floats, failed: NDArray[np.bool_]) -> Floats:
    """The log loss of each episode, where no prediction is surer than 1 %."""
    share = np.clip(predicted, 0.01, 0.99)
    found: Floats = -np.where(failed, np.log(share), np.log(1 - share))
    return found


def environment_auc(table: Table, parts: Any) -> float | None:
    """The area under the ROC curve of held-out episodes where nothing is known but the environment; `None` of one."""
    if len(np.unique(table.environments)) < 2:
        return None
    score = imported("sklearn.metrics", "scikit-learn").roc_auc_score
    areas = []
    for train, test in parts:
        base = table.failed[train].mean()
        rates = {name: table.failed[train][table.environments[train] == name].mean() for name in np.unique(table.environments[train])}
        if 0 < table.failed[test].sum() < len(test):
            areas.append(score(table.failed[test], [rates.get(name, base) for name in table.environments[test]]))
    return float(np.mean(areas))
