// What openapi-typescript makes of openapi.yaml, used by a program that must compile and by lines that must not.

import type { components, operations, paths } from "./api";

type Schemas = components["schemas"];

// The source of a scene is exactly one of text and image; text may stand beside an image.
const text: Schemas["SceneSubmission"] = { text: "a mug", seed: 7 };
const image: Schemas["SceneSubmission"] = { image: { base64: "iVBORw0KGgo=" } };
const both: Schemas["SceneSubmission"] = { text: "a mug", image: { url: "https://example.org/table.png" } };
// @ts-expect-error neither of them
const neither: Schemas["SceneSubmission"] = { seed: 7 };
// @ts-expect-error an image is bytes or an address, not a word
const word: Schemas["SceneSubmission"] = { image: "table.png" };
// @ts-expect-error a form's image comes as a file
const form: Schemas["SceneForm"] = { request: { text: "a mug" } };
// @ts-expect-error no such shape
const shape: Schemas["TableShape"] = "hexagonal";

// Every part of an answer has a name and a type.
export async function make(base: string, body: Schemas["SceneSubmission"]): Promise<ArrayBuffer> {
  const submitted = await fetch(`${base}/scenes`, {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(body),
  });
  if (submitted.status !== 202) {
    const problem: paths["/scenes"]["post"]["responses"]["422"]["content"]["application/problem+json"] =
      await submitted.json();
    throw new Error(`${problem.code}: ${problem.errors?.map((error) => error.pointer).join()}`);
  }
  const scene: Schemas["Scene"] = await submitted.json();
  let job: Schemas["Job"] | null = scene.job;
  while (job && (job.state === "queued" || job.state === "running")) {
    const place: number | undefined = job.queue_position;
    console.log(place, job.estimated_finish_at);
    job = await (await fetch(`${base}${job.links.self}`)).json();
  }
  const query: operations["getBundle"]["parameters"]["query"] = { format: "mjcf" };
  const bundle = await fetch(`${base}${scene.links.bundle}?format=${query?.format}`);
  return bundle.arrayBuffer();
}

export async function names(base: string, sceneId: string): Promise<string[]> {
  const answer = await fetch(`${base}/scenes/${sceneId}/artifacts`);
  const list: operations["listArtifacts"]["responses"]["200"]["content"]["application/json"] = await answer.json();
  return list.artifacts.map((artifact) => artifact.name);
}

export async function late(base: string): Promise<Schemas["FailureClass"][]> {
  const query: operations["listJobs"]["parameters"]["query"] = { state: "failed", page_size: 200 };
  const answer = await fetch(`${base}/jobs?${new URLSearchParams({ state: query.state ?? "failed" })}`);
  const page: Schemas["JobPage"] = await answer.json();
  return page.jobs.flatMap((job) => job.failure?.class ?? []);
}

export default [text, image, both, neither, word, form, shape];
