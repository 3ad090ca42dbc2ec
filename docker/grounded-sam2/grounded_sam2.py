"""Grounding DINO finds boxes for words, SAM 2 the pixels in them: loaded by their own libraries, once.

    uvicorn --factory grounded_sam2:server --host 0.0.0.0 --port 8090

Environment: GROUNDING_MODEL, SAM_MODEL (names or folders of Hugging Face), DEVICE (cuda, cpu), SEGMENTER_KEY
(optional).
"""

import os

import numpy as np
import torch
from sam2.sam2_image_predictor import SAM2ImagePredictor
from transformers import AutoModelForZeroShotObjectDetection, AutoProcessor

from sidecar import Detection, app


class GroundedSam2:
    """The models that answer a question about one image."""

    def __init__(self, grounding_model: str, sam_model: str, device: str):
        self.device = device
        self.processor = AutoProcessor.from_pretrained(grounding_model)
        self.grounding = AutoModelForZeroShotObjectDetection.from_pretrained(grounding_model).to(device).eval()
        self.predictor = SAM2ImagePredictor.from_pretrained(sam_model, device=device)

    @torch.inference_mode()
    def find(self, image, labels, box_threshold, text_threshold):
        # Lower case, each ended by a full stop: so it was trained.
        text = " ".join(f"{label}." for label in labels)
        inputs = self.processor(images=image, text=text, return_tensors="pt").to(self.device)
        outputs = self.grounding(**inputs)
        [result] = self.processor.post_process_grounded_object_detection(
            outputs,
            inputs.input_ids,
            box_threshold=box_threshold,
            text_threshold=text_threshold,
            target_sizes=[image.size[::-1]],
        )
        boxes = result["boxes"].float().cpu().numpy()
        if len(boxes) == 0:
            return []
        self.predictor.set_image(np.asarray(image))
        masks, _, _ = self.predictor.predict(box=boxes, multimask_output=False)
        # One box gives (1, h, w), several (n, 1, h, w).
        masks = np.asarray(masks, bool).reshape(len(boxes), *masks.shape[-2:])
        scores = result["scores"].float().cpu().numpy()
        return [
            Detection(name, float(score), tuple(box), mask)
            for name, score, box, mask in zip(result["labels"], scores, boxes, masks)
        ]


def server():
    device = os.environ.get("DEVICE") or ("cuda" if torch.cuda.is_available() else "cpu")
    models = GroundedSam2(
        os.environ.get("GROUNDING_MODEL", "IDEA-Research/grounding-dino-base"),
        os.environ.get("SAM_MODEL", "facebook/sam2.1-hiera-large"),
        device,
    )
    return app(models.find, os.environ.get("SEGMENTER_KEY"))
