"""python -m unittest discover training: what is wanted of the network can be read back, and what is written is the
network."""

import tempfile
import unittest

import numpy as np
import torch
from PIL import Image
from torch import distributed
from torch.nn import functional as F

import region_score
from encoder import on_colors
from frames import (
    BACKDROP,
    CAMERA,
    CLOSER,
    CROPS,
    FACTS,
    FIRST_OBJECT,
    IGNORED,
    MAX_OBJECTS,
    MAX_SCALE,
    STRIDE,
    TOP,
    WHOLE,
    Crop,
    centroid,
    facts,
    framed,
    maps,
    projected,
    shown_box,
)
from network import BLOCKS, MAPS, WIDTHS, TableNetwork, begin, folded, split
from scores import compared, grouped
from targets import elevation_of, targets
from train import (
    OF_STEPS,
    RISE,
    SMALL,
    WHOLE_STEPS,
    averaged,
    batch,
    crop_of,
    falls_from,
    joined,
    learning_rate,
    losses,
    mean_of_processes,
    nearer,
    numbers_of,
    settle,
    shrunk,
    varied,
)
from variation import pattern, recolored
from without_tables import WithoutTables

MAP_WIDTH, MAP_HEIGHT = (side // STRIDE for side in WHOLE)


def scene():
    """A label map with two touching boxes, one apart, one too small to count, and padding."""
    labels = torch.full((1, MAP_HEIGHT, MAP_WIDTH), TOP, dtype=torch.uint8)
    labels[:, :, -10:] = IGNORED
    labels[0, 20:40, 20:40], labels[0, 20:40, 40:70] = FIRST_OBJECT, FIRST_OBJECT + 1
    labels[0, 80:100, 100:110], labels[0, 60:62, 60:62] = FIRST_OBJECT + 2, FIRST_OBJECT + 3
    known = torch.zeros(1, MAX_OBJECTS, FACTS)
    known[0, 1] = torch.tensor([50.0, 44.5, 24.5, 60.5, 1.0])
    return labels, torch.zeros_like(labels), torch.tensor([[0.6, 0.3, 320.0, 1.0]]), known


def ideal(want):
    """Maps that say exactly what is wanted."""
    kinds = 20.0 * F.one_hot(want["kinds"], 4).permute(0, 3, 1, 2).float()
    def flat(name):
        return 20.0 * (2.0 * want[name].float()[:, None] - 1.0)
    return torch.cat([kinds, flat("outline"), flat("border"), flat("contact"), want["center"][:, None], want["offset"], want["base"], *(want[name][:, None] for name in ("top", "ground", "latitude", "focal"))], 1)


def repeated(tensors, encoder, x):
    """The network from its written tensors and the pretrained encoder."""
    def conv(name, x, stride=1):
        return F.conv2d(x, tensors[f"{name}.weight"], tensors[f"{name}.bias"], stride, tensors[f"{name}.weight"].shape[-1] // 2)
    def block(name, x):
        return F.relu(x + conv(f"{name}.widen", F.relu(conv(f"{name}.narrow", x))))
    outputs = encoder.between(on_colors(0.5 * (x + 1)), tensors["known.blocks"].int().tolist())
    first = len(BLOCKS) - len(outputs)
    skips = []
    for level, count in enumerate(BLOCKS):
        known = conv(f"known.{level - first}", outputs[level - first]) if level >= first else 0.0
        x = F.relu(conv(f"down.{level}", x, 2) + known)
        for k in range(count):
            x = block(f"blocks.{level}.{k}", x)
        skips.append(x)
    x = F.relu(x + conv("spread", x.mean((2, 3), keepdim=True)))
    for level in reversed(range(len(WIDTHS) - 1)):
        x = conv(f"across.{level}", x).repeat_interleave(2, 2).repeat_interleave(2, 3)
        x = block(f"up.{level}", F.relu(x + skips[level]))
    return conv("maps", x)


def descend(process, place):
    """One of two processes, whose gradients are 1 and 10, and 2 and 20."""
    distributed.init_process_group("gloo", f"file://{place}/meeting", rank=process, world_size=2)
    parameters = [torch.zeros(2, 3, requires_grad=True), torch.zeros(4, requires_grad=True)]
    for p, value in zip(parameters, (1.0, 10.0)):
        p.grad = torch.full_like(p, value * (process + 1))
    mean_of_processes(parameters, 2)
    torch.save([p.grad for p in parameters], f"{place}/{process}.pt")
    distributed.destroy_process_group()


class Training(unittest.TestCase):
    def test_what_is_wanted_is_read_back(self):
        labels, flags, cameras, known = scene()
        want = targets(labels, flags, cameras, known)
        ids = grouped(ideal(want)[0])
        self.assertEqual(compared(ids, labels[0]), (3, 3, 0))
        self.assertEqual(len(ids[(labels[0] == FIRST_OBJECT)].unique()), 1)
        self.assertTrue(want["border"][0, 30, 39] and want["border"][0, 30, 40] and not want["border"][0, 30, 30])

    def test_places_know_where_their_object_stands_and_ends(self):
        want = targets(*scene())
        self.assertTrue(want["is_known"][0, 20:40, 40:70].all() and not want["is_known"][0, 20:40, 20:40].any())
        self.assertEqual([30 + 0.5 + 8 * want[name][0, 30, 45].item() for name in ("top", "ground")], [24.5, 60.5])
        x, y = 8 * want["base"][0, :, 30, 45]
        self.assertEqual((45 + 0.5 + x.item(), 30 + 0.5 + y.item()), (50.0, 44.5))

    def test_facts_are_those_of_the_truth(self):
        # A camera 2 m above the table that points straight down, the right of its image to +x.
        eye = {"translation_m": [0.0, 0.0, 2.0], "rotation_xyzw": [1.0, 0.0, 0.0, 0.0]}
        camera = {"fx": 320.0, "fy": 320.0, "cx": 160.0, "cy": 128.0, "world_from_camera": eye}
        np.testing.assert_allclose(projected(camera, [0.5, 0.25, 1.0]), [320.0, 48.0])
        self.assertIsNone(projected(camera, [0.0, 0.0, 2.5]))
        square = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.0, 0.5]]
        np.testing.assert_allclose(centroid(square), [0.5, 0.25])
        instance = {"footprint_m": square, "contact_z_m": 1.0, "size_m": [1.0, 0.5, 0.3]}
        truth = {"width_px": 320, "height_px": 256, "camera": camera, "objects": [instance]}
        known = facts(truth, Crop.whole(320, 256))
        # Rows of the center of the footprint 1 m up, of the point 0.3 m above it and of that on the table.
        rows = [0.5 * (128 - 320 * 0.25 / below) for below in (1.0, 0.7, 2.0)]
        np.testing.assert_allclose(known[0], [160.0, *rows, 1.0], rtol=1e-6)
        self.assertFalse(known[1:].any())
        # Half the image, twice as large.
        closer = facts(truth, Crop((160, 64, 320, 192), WHOLE))
        np.testing.assert_allclose(closer[0], [2 * (160.0 - 80), *(2 * (row - 32) for row in rows), 1.0], rtol=1e-6)

    def test_what_is_spoiled_is_seen(self):
        labels, flags, cameras, known = scene()
        spoiled = ideal(targets(labels, flags, cameras, known))[0]
        spoiled[:, 70:110, 90:120] = 0.0
        spoiled[TOP, 70:110, 90:120] = 20.0
        self.assertEqual(compared(grouped(spoiled), labels[0]), (3, 2, 0))
        invented = ideal(targets(labels, flags, cameras, known))[0]
        invented[FIRST_OBJECT, 100:112, 20:40] = 40.0
        invented[7, 106, 30] = 1.0
        self.assertEqual(compared(grouped(invented), labels[0]), (3, 3, 1))

    def test_written_tensors_are_the_network(self):
        torch.manual_seed(3)
        model = TableNetwork()
        for name, buffer in model.named_buffers():
            if name.endswith("running_mean"):
                buffer.normal_(0.0, 0.2)
            elif name.endswith("running_var"):
                buffer.uniform_(0.5, 2.0)
        model.eval()
        x = torch.rand(2, 3, 64, 96) * 2 - 1
        with torch.no_grad():
            torch.testing.assert_close(repeated(folded(model), model.pretrained[0], x), model(x), rtol=1e-4, atol=1e-4)
        self.assertEqual(model(x).shape[1], sum(n for _, n in MAPS))

    def test_a_deeper_network_begins_as_the_one_that_was_written(self):
        torch.manual_seed(4)
        shallow, deep = TableNetwork((8, 12), (0, 1), ()), TableNetwork((8, 12), (0, 3), ())
        for name, buffer in shallow.named_buffers():
            if name.endswith("running_mean"):
                buffer.normal_(0.0, 0.2)
        tensors, x = folded(shallow), torch.rand(6, 3, 32, 48) * 2 - 1
        begin(deep, tensors, x.split(3))
        with torch.no_grad():
            torch.testing.assert_close(deep.eval()(x), shallow.eval()(x), rtol=1e-4, atol=1e-4)
            # Counted on these frames, the normalizations change nothing for them.
            torch.testing.assert_close(deep.train()(x), shallow(x), rtol=1e-2, atol=1e-2)
        # What passes everything on can still learn.
        deep(x).square().mean().backward()
        self.assertGreater(deep.blocks[1][2].widen.norm.weight.grad.abs().max().item(), 0.0)

    def test_a_network_that_gets_the_pretrained_encoder_begins_as_the_one_that_was_written(self):
        torch.manual_seed(5)
        blind, seeing = TableNetwork((8, 12), (0, 1), ()), TableNetwork((8, 12), (0, 1), (2,))
        x = torch.rand(6, 3, 64, 64) * 2 - 1
        begin(seeing, folded(blind), x.split(3))
        with torch.no_grad():
            torch.testing.assert_close(seeing.eval()(x), blind.eval()(x), rtol=1e-4, atol=1e-4)
        seeing.train()(x).square().mean().backward()
        self.assertGreater(seeing.known[0].norm.weight.grad.abs().max().item(), 0.0)

    def test_light_stays_where_colors_change(self):
        labels, *_ = scene()
        generator = torch.Generator().manual_seed(1)
        flat = torch.full((1, 3, 2 * MAP_HEIGHT, 2 * MAP_WIDTH), 0.5)
        changed = [recolored(flat, labels, generator) for _ in range(40)]
        inside = [one[0, :, 50:70, 50:70] for one in changed]
        self.assertTrue(10 < sum(part.std((1, 2)).max() < 1e-6 for part in inside) <= 40, "an object has one color")
        self.assertGreater(sum((part.mean() - 0.5).abs() > 0.01 for part in inside), 8)
        self.assertGreater(sum(one[0, :, 150:, 30:200].std((1, 2)).max() > 0.02 for one in changed), 5, "tops get patterns")
        self.assertTrue(all((one[..., -16:] == 0.5).all() for one in changed), "padding stays")
        for _ in range(30):
            self.assertTrue(pattern(20, 30, generator).isfinite().all())

    def test_losses_are_computed_on_the_device_of_the_images(self):
        elsewhere = [tensor.to("meta") for tensor in scene()]
        want = targets(*elsewhere)
        parts = losses(torch.zeros(1, 16, MAP_HEIGHT, MAP_WIDTH, device="meta"), want)
        self.assertEqual({value.device.type for value in (*want.values(), *parts.values())}, {"meta"})

    def test_images_without_a_table_want_nothing(self):
        without = WithoutTables(6, seed=3)
        shown = joined([batch(without, np.arange(4)), batch(without, np.arange(4, 6))])
        images, *rest = varied(*shrunk(*shown), torch.Generator().manual_seed(2))
        self.assertEqual(len(images), 6)
        want = targets(*rest)
        self.assertTrue((want["kinds"] == BACKDROP).all() and want["counts"].all())
        self.assertFalse(any(want[name].any() for name in ("outline", "contact", "border", "tells_camera", "is_known", "is_object")))
        self.assertTrue(all(loss.isfinite() for loss in losses(torch.zeros(6, 16, *want["kinds"].shape[1:]), want).values()))
        np.testing.assert_array_equal(WithoutTables(6, seed=3).images, without.images)

    def test_processes_take_the_mean_of_their_gradients(self):
        with tempfile.TemporaryDirectory() as place:
            torch.multiprocessing.spawn(descend, (place,), 2)
            ours, theirs = (torch.load(f"{place}/{process}.pt", weights_only=True) for process in range(2))
        torch.testing.assert_close(ours, theirs, rtol=0, atol=0)
        torch.testing.assert_close(ours, [torch.full((2, 3), 1.5), torch.full((4,), 15.0)])

    def test_places_of_the_top_tell_the_camera(self):
        labels, flags, cameras, known = scene()
        flags[:, 20:90, 15:120] = 1
        by_name = split(ideal(targets(labels, flags, cameras, known)))
        elevation, log_focal = elevation_of(by_name, cameras[:, 2])
        self.assertAlmostEqual(elevation.item(), 0.6, places=5)
        self.assertAlmostEqual(log_focal.item(), 0.3, places=5)

    def test_small_frames_want_the_same_of_the_same_objects(self):
        labels, flags, cameras, known = scene()
        whole = targets(labels, flags, cameras, known)
        images = torch.rand(1, 3, 2 * MAP_HEIGHT, 2 * MAP_WIDTH)
        small, labels, flags, cameras, known = shrunk(images, labels, flags, cameras, known)
        self.assertEqual(small.shape, (1, 3, *reversed(SMALL[WHOLE])))
        want = targets(labels, flags, cameras, known)
        # Row 20 and column 27 of the small map show row 32 and column 45 of the whole one.
        for name in ("top", "ground"):
            self.assertAlmostEqual(want[name][0, 20, 27].item(), 0.625 * whole[name][0, 32, 45].item(), delta=0.05)
        self.assertAlmostEqual(want["latitude"][0, 20, 27].item(), whole["latitude"][0, 32, 45].item(), delta=0.01)

    def test_enlarged_frames_want_the_same_of_the_same_objects(self):
        labels, flags, cameras, known = scene()
        whole, sides = targets(labels, flags, cameras, known), set()
        images = labels.repeat_interleave(2, 1).repeat_interleave(2, 2)[:, None].float() / 255
        for seed in range(30):
            shown, near, _, _, there = nearer(images, labels, flags, cameras, known, torch.Generator().manual_seed(seed))
            difference = (F.avg_pool2d(shown, 2)[0, 0] - near[0].float() / 255).abs()
            self.assertLess((difference > 1e-3).float().mean().item(), 0.05, "only edges are softer than labels")
            ys, xs = torch.nonzero(near[0] == FIRST_OBJECT + 1, as_tuple=True)
            if len(xs) == 0 or xs.max() - xs.min() < 29 or ys.max() - ys.min() < 19:
                continue
            larger = (xs.max() - xs.min() + 1).item() / 30
            sides.add(larger)
            # The same corner of the object, and its base and rows from there.
            want = targets(near, flags, cameras, there)
            self.assertEqual(want["is_known"][0, ys.min(), xs.min()], True)
            for name in ("top", "ground"):
                self.assertAlmostEqual(want[name][0, ys.min(), xs.min()].item(), larger * whole[name][0, 20, 40].item(), delta=0.25)
            self.assertAlmostEqual(want["base"][0, 0, ys.min(), xs.min()].item(), larger * whole["base"][0, 0, 20, 40].item(), delta=0.25)
        self.assertTrue(min(sides) == 1.0 and max(sides) > 1.2, sides)

    def test_the_average_follows_what_changes(self):
        torch.manual_seed(5)
        model = TableNetwork((8, 12), (0, 1), ())
        average = averaged(model)
        average.update_parameters(model)
        for parameter in model.parameters():
            parameter.data += 1.0
        for _ in range(4000):
            average.update_parameters(model)
        for ours, theirs in zip(average.module.parameters(), model.parameters()):
            torch.testing.assert_close(ours, theirs, rtol=0, atol=1e-2)

    def test_settled_normalizations_count_no_more_and_still_learn(self):
        torch.manual_seed(6)
        model = TableNetwork((8, 12), (0, 1), ()).train()
        x = torch.rand(4, 3, 32, 48) * 2 - 1
        model(x)
        settle(model)
        before = {name: buffer.clone() for name, buffer in model.named_buffers()}
        maps_ = model(3 * x)
        self.assertTrue(all((buffer == before[name]).all() for name, buffer in model.named_buffers()))
        torch.testing.assert_close(maps_, model.eval()(3 * x))
        maps_.square().mean().backward()
        self.assertGreater(model.down[0].norm.weight.grad.abs().max().item(), 0.0)

    def test_every_image_once_an_epoch(self):
        seen = np.concatenate([numbers_of(step, 4, 10, 7) for step in range(5)])
        self.assertEqual(sorted(seen[:10]), list(range(10)))
        self.assertEqual(sorted(seen[10:]), list(range(10)))
        self.assertFalse((seen[:10] == seen[10:]).all())
        np.testing.assert_array_equal(numbers_of(3, 4, 10, 7), numbers_of(3, 4, 10, 7))

    def test_a_longer_run_begins_as_a_shorter_one(self):
        before = range(falls_from(4000))
        self.assertEqual([learning_rate(k, 4000, 1.0) for k in before], [learning_rate(k, 9000, 1.0) for k in before])
        self.assertEqual([learning_rate(k, 4000, 1.0) for k in (RISE, falls_from(4000), 3999)], [1.0, 1.0, 0.01])
        self.assertAlmostEqual(learning_rate((falls_from(4000) + 4000) // 2, 4000, 1.0), 0.5)

    def test_maps_lie_where_the_frame_shows_the_image(self):
        labels = np.zeros((300, 400), np.uint8)
        labels[:, 200:] = FIRST_OBJECT
        outline = [[0, 0], [200, 0], [200, 300], [0, 300]]
        instance = {"contact_px": [[250, 100], [350, 100], [350, 200], [250, 200]]}
        truth = {"table": {"outline_px": outline}, "objects": [instance]}
        whole = Crop.whole(400, 300)
        label, flags = maps(labels, truth, whole)
        _, (x, y), shown = whole.placement()
        self.assertEqual((x, y, shown), (0, 8, (320, 240)))
        self.assertTrue((label[: y // 2] == IGNORED).all() and (label[y // 2 : -y // 2] != IGNORED).all())
        self.assertEqual(label[60, 79], 0)
        self.assertEqual(label[60, 80], FIRST_OBJECT)
        self.assertTrue(flags[60, 40] & 1 and not flags[60, 120] & 1)
        self.assertTrue((flags & 2).any() and not (flags[:, :80] & 2).any())
        closer = Crop((40, 100, 360, 244), CLOSER[1])
        label, flags = maps(labels, truth, closer)
        self.assertEqual(label.shape, closer.map_shape)
        self.assertTrue((label[:, :160] == 0).all() and (label[:, 160:] == FIRST_OBJECT).all())
        self.assertTrue((flags[:, :159] & 1).all() and not (flags[:, 161:] & 1).any())

    def test_a_closer_crop_shows_its_box_larger_and_stays_in_the_image(self):
        for box in ((100, 50, 400, 150), (0, 0, 80, 300), (500, 370, 512, 384), (0, 0, 512, 384)):
            crop = Crop.closer(512, 384, box)
            scale, (x, y), shown = crop.placement()
            self.assertGreaterEqual(scale, Crop.whole(512, 384).placement()[0] * 0.99)
            self.assertLessEqual(scale, 1.01 * MAX_SCALE)
            left, upper, right, lower = crop.part
            self.assertTrue(0 <= left < right <= 512 and 0 <= upper < lower <= 384)
            self.assertTrue(left <= box[0] + 1 and upper <= box[1] + 1 and right >= box[2] - 1 and lower >= box[3] - 1)
        wide = Crop((36, 4, 463, 196), CLOSER[1])
        self.assertEqual(Crop.closer(512, 384, (100, 50, 400, 150)), wide)
        image = Image.fromarray(np.arange(512 * 384 * 3, dtype=np.uint32).astype(np.uint8).reshape(384, 512, 3))
        self.assertEqual(framed(image, wide).shape, (288, 640, 3))

    def test_a_closer_crop_holds_the_top_and_all_objects(self):
        labels = np.zeros((384, 512), np.uint8)
        labels[60:200, 300:320] = FIRST_OBJECT
        truth = {"table": {"outline_px": [[100, 150], [400, 150], [420, 250], [90, 250]]}}
        for seed in range(20):
            left, upper, right, lower = shown_box(labels, truth, np.random.default_rng(seed))
            self.assertTrue(0 <= left < 90 and 0 <= upper < 60 and 420 < right <= 512 and 250 < lower <= 384)
        self.assertEqual(shown_box(np.zeros((384, 512), np.uint8), {"table": {"outline_px": []}}, None), (0, 0, 512, 384))

    def test_only_whole_images_tell_the_camera(self):
        labels, flags, cameras, known = scene()
        maps_ = torch.zeros(1, sum(n for _, n in MAPS), MAP_HEIGHT, MAP_WIDTH)
        def losses_of_camera(is_whole):
            return losses(maps_, targets(labels, flags, cameras * torch.tensor([1.0, 1.0, 1.0, is_whole]), known))
        self.assertEqual(cameras.shape[1], CAMERA)
        self.assertGreater(losses_of_camera(1.0)["latitude"].item(), 0.1)
        self.assertEqual([losses_of_camera(0.0)[name].item() for name in ("latitude", "focal")], [0.0, 0.0])
        self.assertEqual(losses_of_camera(0.0)["kinds"], losses_of_camera(1.0)["kinds"])

    def test_every_crop_gets_its_steps_in_turn(self):
        crops = dict(zip(CROPS, (100, 30, 70)))
        steps = [crop_of(step, crops) for step in range(100 * OF_STEPS)]
        for crop in CROPS:
            self.assertEqual([nth for own, nth in steps if own == crop], list(range(sum(own == crop for own, _ in steps))))
        def share(name):
            return sum(own == name for own, _ in steps) / len(steps)
        self.assertEqual(share("whole"), WHOLE_STEPS / OF_STEPS)
        self.assertAlmostEqual(share(list(CROPS)[1]), 0.3 * (1 - WHOLE_STEPS / OF_STEPS), delta=0.01)
        self.assertEqual(crop_of(5, {"whole": 10, **dict.fromkeys(list(CROPS)[1:], 0)}), ("whole", 5))


class RegionScores(unittest.TestCase):
    def test_what_tells_objects_is_found_and_what_does_not_counts_little(self):
        measures = torch.randn(4000, 3, dtype=torch.float64, generator=torch.Generator().manual_seed(1)) * 5 + 2
        # The first tells by its value, the second by how far it is from the mean.
        odds = 0.4 * (measures[:, 0] - 2) + 0.1 * (measures[:, 1] - 2) ** 2 - 2
        is_object = (torch.rand(4000, dtype=torch.float64, generator=torch.Generator().manual_seed(2)) < odds.sigmoid()).double()
        fit = region_score.fitted(measures, is_object)
        mean, spread, first, second, at_the_means = fit
        self.assertLess((mean - 2).abs().max(), 0.3)
        self.assertLess((first - torch.tensor([2.0, 0.0, 0.0])).abs().max(), 0.3)
        self.assertLess((second - torch.tensor([0.0, 2.5, 0.0])).abs().max(), 0.4)
        self.assertLess((at_the_means + 2).abs(), 0.3)
        self.assertLess((region_score.log_odds(measures, fit) - odds).abs().median(), 0.4)

    def test_regions_are_read_from_the_file(self):
        def image(*overlaps):
            return {"number": 0, "regions": [{"measures": [1.0, 2.0], "overlap": o} for o in overlaps]}
        measures, is_object = region_score.regions_of([image(0.2, 0.9), image(0.5)])
        self.assertEqual((tuple(measures.shape), is_object.tolist()), ((3, 2), [0.0, 1.0, 0.0]))


if __name__ == "__main__":
    unittest.main()
