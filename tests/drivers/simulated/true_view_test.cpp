
#include "drivers/simulated/true_view.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "drivers/errors.hpp"

namespace shaker::simulated {
namespace {

CameraTruth wrong_camera() {
    CameraTruth camera = paper_scene(Detail::positions).cameras[0];
    camera.optics = {.mm_per_px = 0.41,
                     .distance_mm = 620,
                     .k1 = -0.5,
                     .tilt_x_deg = 3,
                     .tilt_y_deg = -1,
                     .turn_deg = 1.5};
    return camera;
}

TEST(TrueViewTest, IsTheToldViewWhenNothingIsWrong) {
    const CameraTruth camera = paper_scene().cameras[0];
    const View truth = true_view(camera);
    EXPECT_EQ(truth.lens, Lens{});
    EXPECT_EQ(truth.mm_per_px, camera.view.mm_per_px);
    EXPECT_EQ(seen_at(truth, 12, 0.02, 160, 50, 2500), (optics::Point{160 + 0.02 * 2500, 50}));
}

TEST(TrueViewTest, SightingsLieWhereTheTrueLensPutsThem) {
    const CameraTruth camera = wrong_camera();
    const View truth = true_view(camera);
    const PictureLayout layout = layout_of(camera, WalkerTruth{});
    const auto walker_mm = [&](double position) {
        double sum = 0;
        constexpr int frames = 100;
        for (int n = 0; n < frames; ++n) {
            const auto seen = sightings(camera, layout, std::array{Pose{0, position}}, {n}, true, 5).at(0);
            sum +=
                optics::place_at(truth, camera.view.targets[0].offset_mm, {seen.x_px, seen.y_px})[0] / frames;
        }
        return sum;
    };
    const double zero = walker_mm(0);
    for (const double position : {-0.09, 0.03, 0.08})
        EXPECT_NEAR(walker_mm(position) - zero, 1e3 * position, 6 * 0.4 * sighting_sd_px / 10);
    EXPECT_GT(std::abs(layout.walker_px_per_m /
                           layout_of(paper_scene(Detail::positions).cameras[0], {}).walker_px_per_m -
                       1),
              0.02);
}

TEST(TrueViewTest, RenderedMarksAreAPitchApartOnTheBase) {
    CameraTruth camera = wrong_camera();
    camera.width = 640;
    camera.noise_dn = camera.light_gradient = 0;
    camera.optics.k1 = -1.5;
    Renderer renderer{camera, {}, 1};
    std::vector<std::byte> pixels(static_cast<std::size_t>(camera.width) *
                                  static_cast<std::size_t>(camera.height));
    renderer.render(std::array{Pose{}}, {0}, pixels);
    const PictureLayout layout = layout_of(camera, {});
    const int row = static_cast<int>(0.5 * (layout.marks_top + layout.marks_bottom));
    std::vector<double> places;  // centres of the dark marks, mm
    double darkness = 0, moment = 0;
    for (int x = 0; x < camera.width; ++x) {
        const int grey = std::to_integer<int>(pixels[static_cast<std::size_t>(row * camera.width + x)]);
        const double dark = std::max(0, 120 - grey);
        darkness += dark;
        moment += dark * x;
        if (dark > 0 || darkness == 0) continue;
        places.push_back(
            optics::place_at(true_view(camera), 0, {moment / darkness, static_cast<double>(row)})[0]);
        darkness = moment = 0;
    }
    ASSERT_GT(places.size(), 25U);
    for (std::size_t k = 2; k + 1 < places.size(); ++k) EXPECT_NEAR(places[k] - places[k - 1], 8, 0.1) << k;
}

TEST(TrueViewTest, BoardsMoveInTheFirstQuarterOfTheirTime) {
    CameraTruth camera = wrong_camera();
    camera.boards = "-20 0 0 0 20 5 90 12";
    camera.board_s = 2;
    const ShownBoards boards{camera};
    ASSERT_TRUE(boards.any());
    const optics::BoardPose first = boards.at(0), between = boards.at(2.25), second = boards.at(2.5);
    EXPECT_EQ(boards.at(1.9).origin_mm, first.origin_mm);
    EXPECT_EQ(boards.at(100).origin_mm, second.origin_mm);
    EXPECT_NEAR(second.turn_rad, 0.5 * std::numbers::pi, 1e-12);
    EXPECT_NEAR(between.turn_rad, 0.25 * std::numbers::pi, 1e-12);
    EXPECT_EQ(second.offset_mm, 12);
    EXPECT_TRUE(board_places("1 2 3").empty());
    EXPECT_TRUE(board_places("1 2 3 x").empty());
}

TEST(TrueViewTest, SceneKeepsTheKeysAndRefusesOddBoards) {
    const std::string keys =
        "[side]\ntrue_mm_per_px = 0.41\ntrue_k1 = -0.2\ntrue_tilt_y_deg = 3\nboards = '0 0 0 0'\nboard_s = "
        "3\n";
    const Scene scene = parse_scene(keys, "scene.toml");
    EXPECT_EQ(scene.cameras[1].optics.tilt_y_deg, 3);
    const std::string text = scene_text(scene);
    EXPECT_EQ(scene_text(parse_scene(text, "again.toml")), text);
    EXPECT_NE(text.find("true_k1 = -0.2\n"), std::string::npos);
    EXPECT_EQ(scene_text(paper_scene()).find("true_"), std::string::npos);
    EXPECT_THROW(parse_scene("[top]\nboards = '0 0 0'\n", "scene.toml"), InputError);
}

}  // namespace
}  // namespace shaker::simulated
