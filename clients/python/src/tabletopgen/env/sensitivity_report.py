"""The report of a sensitivity analysis: factors that explain failures, in numbers and in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from tabletopgen.env.rollout_report import cell, counted, said
from tabletopgen.env.sensitivity_model import PARTS, REPEATS, Models
from tabletopgen.env.sensitivity_splits import MIN_SHARE, MIN_SIDE, SHUFFLES, Tested, probability_beside
from tabletopgen.env.sensitivity_table import Table

FORMAT = "tabletopgen-sensitivity/1"
# A factor is named where chance explains as much less often than this.
NAMED_BELOW = 0.05
# Named factors that are compared with each other.
COMPARED = 10
# Relations of a named factor to one before it.
SEPARATE, FOLLOWS, ALIKE = "separate", "follows", "indistinguishable"
# Factors in the table of the text beyond those that are named.
SHOWN = 8


def document_of(table: Table, factors: Sequence[Tested], models: Models | None, policy: str, seed: int) -> dict[str, Any]:
    """The content of `sensitivity.json`."""
    named = [one for one in factors if one.corrected < NAMED_BELOW]
    relations = related(named[:COMPARED], table, seed)
    return {
        "format": FORMAT,
        "policy": policy,
        "seed": seed,
        "overall": counts(table, np.ones(len(table.failed), dtype=bool)),
        "starts": len(np.unique(table.starts)),
        "environments": len(np.unique(table.environments)),
        "shuffles": SHUFFLES,
        "named": [one.name for one in named],
        "factors": [factor_document(one, table, relations.get(one.name)) for one in factors],
        "constant": sorted(table.constant),
        "merged": {name: list(others) for name, others in table.merged.items()},
        "not_split": sorted({one.name for one in table.factors} - {one.name for one in factors}),
        "model": model_document(models) if models is not None else None,
    }


def related(named: Sequence[Tested], table: Table, seed: int) -> dict[str, dict[str, Any]]:
    """The relation of each named factor to those before it that are separate: it follows one beside which it explains
    no more, or cannot be distinguished from one of which the same holds the other way round, too."""
    found: dict[str, dict[str, Any]] = {}
    separate: list[Tested] = []
    for one in named:
        found[one.name] = {"relation": SEPARATE, "to": None}
        for other in separate:
            own, others = (probability_beside(*pair, table, seed) for pair in ((one, other), (other, one)))
            if own >= NAMED_BELOW:
                relation = ALIKE if others >= NAMED_BELOW else FOLLOWS
                found[one.name] = {"relation": relation, "to": other.name, "probability_beside": own, "of_the_other": others}
                break
        else:
            separate.append(one)
    return found


def factor_document(one: Tested, table: Table, relation: Mapping[str, Any] | None) -> dict[str, Any]:
    """The findings about one factor."""
    factor, second = one.splits.factor, one.splits.second[one.best]
    at = one.splits.at[one.best]
    split: dict[str, Any] = {"first": counts(table, factor.present & ~second), "second": counts(table, second)}
    if factor.is_number:
        low, high = one.splits.between[one.best]
        split |= {"threshold": at, "between": [low, high], "about_as_good": list(one.about_as_good(table))}
    else:
        split["word"] = at
    return {
        "name": one.name,
        "kind": "number" if factor.is_number else "words",
        "episodes": int(factor.present.sum()),
        "explained": one.explained,
        "probability": one.probability,
        "corrected": one.corrected,
        "split": split,
        **(relation or {}),
    }


def counts(table: Table, rows: Any) -> dict[str, Any]:
    """The count of successes of some episodes, with its interval."""
    return counted({"success": not failed} for failed in table.failed[rows])


def model_document(models: Models) -> dict[str, Any]:
    return {
        "parts": PARTS,
        "repeats": REPEATS,
        "base_log_loss": models.base_log_loss,
        "environment_auc": models.environment_auc,
        "best": models.best.kind,
        "models": [asdict(model) for model in models.models],
        "rules": models.rules,
    }


def markdown(document: Mapping[str, Any]) -> str:
    """The content of `sensitivity.md`."""
    overall = document["overall"]
    lines = [f"# Sensitivity of `{document['policy']}`", ""]
    lines += [f"{said(overall)}, from {document['starts']} starts. Environments: {document['environments']}.", "", *verdict(document)]
    lines += factor_table(document)
    lines += [
        "",
        f"A split has {MIN_SIDE} episodes or more and {100 * MIN_SHARE:g} % on each side. *Chance* is the share of {document['shuffles']}"
        " shuffles of outcomes",
        "between starts in which any factor explains as much. *Explained* is the share of the deviance. The best split was chosen,",
        "so rates on its sides are farther apart than new episodes would show. Intervals are those of Wilson for 95 %.",
    ]
    if document["constant"]:
        lines += ["", f"Equal in all episodes, and so unknown: {', '.join(document['constant'])}."]
    if document["merged"]:
        words = "; ".join(f"{name} for {', '.join(others)}" for name, others in document["merged"].items())
        lines += ["", f"One factor stands for others that order these episodes alike: {words}."]
    if document["not_split"]:
        lines += ["", f"With too few episodes beside one value: {', '.join(document['not_split'])}."]
    lines += model_lines(document)
    lines += [f"\n![{row['name']}]({row['plot']})" for row in document["factors"] if "plot" in row]
    return "\n".join(lines) + "\n"


def verdict(document: Mapping[str, Any]) -> list[str]:
    """The factors that explain failure, in words."""
    failures = document["overall"]["episodes"] - document["overall"]["successes"]
    if not failures:
        return ["No episode failed: there is nothing to explain."]
    if not document["overall"]["successes"]:
        return ["Every episode failed: nothing that differs between them explains it."]
    if not document["named"]:
        few = f" {failures} failures are few." if failures < 2 * MIN_SIDE else ""
        return [f"**No recorded factor explains the failures** beyond chance.{few} What decides is not recorded, or is chance."]
    rows = {row["name"]: row for row in document["factors"]}
    return ["Failures are explained by:", "", *(f"{place}. {named_line(rows[name])}" for place, name in enumerate(document["named"], 1))]


def named_line(row: Mapping[str, Any]) -> str:
    """One named factor in words: where it succeeds and where not, and how it is related to others."""
    first, second = row["split"]["first"], row["split"]["second"]
    line = f"**{row['name']}**: {sides(row)[0]} {rate(first)}, {sides(row)[1]} {rate(second)}."
    if "about_as_good" in row["split"]:
        low, high = row["split"]["about_as_good"]
        line += f" Thresholds from {low:.4g} to {high:.4g} are about as good."
    if row.get("relation") == FOLLOWS:
        line += f" It explains no more beside {row['to']}."
    elif row.get("relation") == ALIKE:
        line += f" These episodes cannot tell it from {row['to']}: both varied together."
    return line


def sides(row: Mapping[str, Any]) -> tuple[str, str]:
    """Both sides of a split in words."""
    split = row["split"]
    if "threshold" in split:
        return f"up to {split['threshold']:.4g}", "above"
    return f"other than {cell(split['word'])!r}", f"{cell(split['word'])!r}"


def rate(found: Mapping[str, Any]) -> str:
    low, high = found["wilson_95"]
    return f"{found['successes']} of {found['episodes']} ({100 * low:.0f} % to {100 * high:.0f} %)"


def factor_table(document: Mapping[str, Any]) -> list[str]:
    """Lines of the table of the factors that explain most."""
    rows = document["factors"][: max(len(document["named"]), SHOWN)]
    if not rows:
        return []
    lines = ["", "| factor | split | successes before | successes after | explained | chance |", "| --- | --- | --- | --- | ---: | ---: |"]
    for row in rows:
        first, second = row["split"]["first"], row["split"]["second"]
        split = f"{row['split']['threshold']:.4g}" if "threshold" in row["split"] else cell(row["split"]["word"])
        shares = f"{100 * row['explained']:.0f} % | {row['corrected']:.3f}"
        lines.append(f"| {row['name']} | {split} | {rate(first)} | {rate(second)} | {shares} |")
    return lines


def model_lines(document: Mapping[str, Any]) -> list[str]:
    """All factors at once, in words."""
    model = document["model"]
    if model is None:
        return ["", "No model of all factors is fitted: that needs five starts with failures and five with successes."]
    lines = ["", "## All factors at once", "", "| model | log loss, held out | area under the curve, held out |", "| --- | ---: | ---: |"]
    lines += [f"| always the share of failures | {model['base_log_loss']:.3f} | 0.500 |"]
    if model["environment_auc"] is not None:
        lines += [f"| the environment alone | | {model['environment_auc']:.3f} |"]
    lines += [f"| {one['kind']} | {one['log_loss']:.3f} | {one['auc']:.3f} |" for one in model["models"]]
    lines += ["", f"Each episode was predicted by models without its start ({model['parts']} parts, divided {model['repeats']} times)."]
    best = next(one for one in model["models"] if one["kind"] == model["best"])
    if best["log_loss"] >= model["base_log_loss"]:
        return [*lines, "**No model predicts failures** better than their share does, so its rules mean nothing and are left out."]
    lines += ["", f"Log loss that shuffling one factor adds to the {best['kind']}, with 95 % of parts and shuffles:", ""]
    lines += ["| factor | added | from | to |", "| --- | ---: | ---: | ---: |"]
    lines += [f"| {one['name']} | {one['mean']:.3f} | {one['low']:.3f} | {one['high']:.3f} |" for one in best["importances"][:SHOWN]]
    return [*lines, "", "The tree of all episodes, which says where it fails (`True`):", "", "```", model["rules"].rstrip(), "```"]
