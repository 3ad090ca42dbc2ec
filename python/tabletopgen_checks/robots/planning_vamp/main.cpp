// Solves or checks problems of the Panda with VAMP, as its script evaluate_mbm.py does, without Python.
//
//     vamp plan PROBLEMS REPEATS      one line a problem: solved plan_ns total_ns raw_cost cost
//     vamp check PROBLEMS PATHS       one line a path: 1 if VAMP calls every edge valid
//
// PROBLEMS has one problem a block: "problem", start (7), goal (7), then lines "capsule x1 y1 z1 x2 y2 z2 r" and
// "cuboid center(3) x_axis(3) y_axis(3) z_axis(3) half_extents(3)", then "end". PATHS has one path a line: the
// number of configurations, then their joints. Times are the least of REPEATS runs.

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <limits>
#include <string>
#include <vector>

#include <vamp/collision/factory.hh>
#include <vamp/planning/rrtc.hh>
#include <vamp/planning/simplify.hh>
#include <vamp/planning/validate.hh>
#include <vamp/random/halton.hh>
#include <vamp/robots/panda.hh>

using Robot = vamp::robots::Panda;
static constexpr std::size_t rake = vamp::FloatVectorWidth;
using EnvironmentInput = vamp::collision::Environment<float>;
using Environment = vamp::collision::Environment<vamp::FloatVector<rake>>;
using RRTC = vamp::planning::RRTC<Robot, rake, Robot::resolution>;

struct Problem
{
    Robot::Configuration start;
    Robot::Configuration goal;
    Environment environment;
};

static auto read_configuration(std::istream &in) -> Robot::Configuration
{
    alignas(Robot::Configuration::S::Alignment) std::array<float, Robot::Configuration::num_scalars_rounded> values{};
    for (std::size_t joint = 0; joint < Robot::dimension; ++joint)
    {
        in >> values[joint];
    }
    return Robot::Configuration(values.data());
}

static auto read_problem(std::istream &in) -> Problem
{
    EnvironmentInput input;
    Problem problem{read_configuration(in), read_configuration(in), {}};
    std::string word;
    while (in >> word and word != "end")
    {
        std::array<float, 15> v{};
        const auto count = word == "capsule" ? 7U : 15U;
        for (auto i = 0U; i < count; ++i)
        {
            in >> v[i];
        }
        if (word == "capsule")
        {
            namespace endpoints = vamp::collision::factory::capsule::endpoints;
            auto capsule = endpoints::flat(v[0], v[1], v[2], v[3], v[4], v[5], v[6]);
            auto &capsules = capsule.xv == 0.F and capsule.yv == 0.F ? input.z_aligned_capsules : input.capsules;
            capsules.emplace_back(capsule);
        }
        else
        {
            const auto cuboid = vamp::collision::Cuboid<float>(
                v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8], v[9], v[10], v[11], v[12], v[13], v[14]);
            auto &cuboids = cuboid.axis_3_z == 1.F ? input.z_aligned_cuboids : input.cuboids;
            cuboids.emplace_back(cuboid);
        }
    }
    input.sort();
    problem.environment = Environment(input);
    return problem;
}

static void plan(const Problem &problem, int repeats)
{
    vamp::planning::RRTCSettings settings;
    settings.range = 1.0;
    vamp::planning::SimplifySettings simplify_settings;
    auto rng = std::make_shared<vamp::rng::Halton<Robot>>();
    auto plan_ns = std::numeric_limits<std::size_t>::max();
    auto total_ns = plan_ns;
    float raw_cost = 0;
    float cost = 0;
    bool solved = false;
    for (int repeat = 0; repeat < repeats; ++repeat)
    {
        rng->reset();
        const auto result = RRTC::solve(problem.start, problem.goal, problem.environment, settings, rng);
        solved = not result.path.empty();
        if (not solved)
        {
            break;
        }
        const auto simple = vamp::planning::simplify<Robot, rake, Robot::resolution>(
            result.path, problem.environment, simplify_settings, rng);
        plan_ns = std::min(plan_ns, result.nanoseconds);
        total_ns = std::min(total_ns, result.nanoseconds + simple.nanoseconds);
        raw_cost = result.path.cost();
        cost = simple.path.cost();
    }
    std::cout << solved << " " << plan_ns << " " << total_ns << " " << raw_cost << " " << cost << "\n";
}

static auto is_valid(const Problem &problem, const std::vector<Robot::Configuration> &path) -> bool
{
    const auto valid = [&](const auto &from, const auto &to)
    { return vamp::planning::validate_motion<Robot, rake, Robot::resolution>(from, to, problem.environment); };
    bool all = path.size() >= 2 and valid(path.front(), path.front());
    for (std::size_t i = 1; all and i < path.size(); ++i)
    {
        all = valid(path[i - 1], path[i]);
    }
    return all;
}

int main(int count, char **arguments)
{
    if (count != 4)
    {
        std::cerr << "usage: vamp plan PROBLEMS REPEATS | vamp check PROBLEMS PATHS\n";
        return 2;
    }
    const std::string mode = arguments[1];
    std::ifstream problems(arguments[2]);
    std::ifstream paths(mode == "check" ? arguments[3] : "/dev/null");
    std::string word;
    while (problems >> word and word == "problem")
    {
        const auto problem = read_problem(problems);
        if (mode == "plan")
        {
            plan(problem, std::atoi(arguments[3]));
            continue;
        }
        std::size_t length = 0;
        paths >> length;
        std::vector<Robot::Configuration> path;
        for (std::size_t i = 0; i < length; ++i)
        {
            path.push_back(read_configuration(paths));
        }
        std::cout << is_valid(problem, path) << "\n";
    }
    return 0;
}
