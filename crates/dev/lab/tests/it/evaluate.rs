//! The layout benchmark on scenes small enough for a test: scores are small, repeat, and depend on no thread.

use lab::app::evaluation;
use lab::benchmark::layout::{Difficulty, LayoutBench, SceneScore};
use lab::benchmark::report::Section;
use lab::benchmark::scenes::{BenchmarkScene, Family, Outline};
use lab::benchmark::score::YawStatus;
use ports::Call;
use tabletopgen::app::config::layers::{Sources, load};
use tabletopgen::pipeline::checkpoint::CancelFlag;

fn scene(text: &'static str, outline: Outline, seed: u64) -> BenchmarkScene {
    let name = format!("small_{seed}");
    BenchmarkScene { name, family: Family::DiningKitchen, outline, text, seed, max_objects: 3 }
}

async fn scored(scene: &BenchmarkScene, difficulty: Difficulty, threads: usize) -> SceneScore {
    let sources = Sources {
        arguments: vec![
            ("worker.cpu_threads".to_owned(), threads.to_string(), "--threads"),
            ("store.fsync".to_owned(), "false".to_owned(), "--set"),
            ("image_generator.width_px".to_owned(), "640".to_owned(), "--set"),
            ("image_generator.height_px".to_owned(), "480".to_owned(), "--set"),
        ],
        ..Sources::default()
    };
    let config = load(sources).unwrap().config;
    let (home, cancel) = (tempfile::tempdir().unwrap(), CancelFlag::default());
    let cpu = evaluation::cpu(&config).unwrap();
    let request = LayoutBench::request(scene);
    let opened = evaluation::opened(home.path(), &config, &cpu, &cancel, &request).await.unwrap();
    let call = Call::without_budget(cpu, cancel);
    evaluation::layout_bench(&config).score(scene, difficulty, opened.checkpoints, &call).await.unwrap()
}

#[tokio::test]
async fn clean_scene_layout_matches_truth() {
    let scene = scene("a table with a mug, a book and a plate", Outline::Rectangular, 5);
    let score = scored(&scene, Difficulty::Clean, 1).await;
    assert_eq!(score, scored(&scene, Difficulty::Clean, 2).await, "scores depend on the number of threads");
    let yaw_status: Vec<YawStatus> = score.objects.iter().map(|object| object.yaw_status).collect();
    assert_eq!(yaw_status, [YawStatus::Scored, YawStatus::Scored, YawStatus::OrderZero]);
    for object in &score.objects {
        assert!(object.yaw_error_deg.is_none_or(|error| error < 3.0), "{object:?}");
        assert!(object.position_error_m.is_some_and(|error| error < 0.01), "{object:?}");
        assert!(object.scale_error < 0.02, "{object:?}");
    }
    assert!(
        score.ablation.full.pairs == 6 && score.ablation.full.colliding.is_empty(),
        "{:?}",
        score.ablation
    );
    let section = Section::new(Difficulty::Clean, vec![score], Vec::new());
    assert_eq!((section.all.scenes, section.all.objects, section.families.len()), (1, 3, 1));
}

#[tokio::test]
async fn noise_affects_stage_inputs_but_not_truth() {
    let scene = scene("a round table with a mug and a book", Outline::RoundOrOval, 6);
    let score = scored(&scene, Difficulty::Noisy, 2).await;
    assert!(score.objects.iter().all(|object| object.scale_error > 1e-6), "{score:?}");
    assert!(score.objects.iter().all(|object| object.position_error_m.is_some_and(|e| e > 1e-6 && e < 0.1)));
}
