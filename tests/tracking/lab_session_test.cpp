// Both views of the computed session, compared with its exact positions.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "calibration/camera/camera_scale.hpp"
#include "tests/support/shared_data.hpp"
#include "tests/support/tracking/grey_movie.hpp"
#include "tracking/tracker.hpp"

namespace shaker::tracking {
namespace {

Target target(const std::string& name, TargetKind kind, std::array<int, 4> roi, double offset_mm) {
    Target t{name, kind};
    t.roi_px = roi;
    t.offset_mm = offset_mm;
    return t;
}

View top_view() {
    View view;
    view.camera = "top";
    view.mm_per_px = 0.25;
    view.distance_mm = 600;
    Target walker = target("walker", TargetKind::disc, {95, 20, 165, 124}, 12);
    walker.diameter_mm = 30;
    Target base = target("base", TargetKind::dots, {16, 0, 480, 24}, 0);
    base.diameter_mm = 2.6;
    base.pitch_mm = 8;
    base.polarity = Polarity::dark;
    view.targets = {walker, base};
    return view;
}

View side_view() {
    View view;
    view.camera = "side";
    view.mm_per_px = 0.25;
    view.distance_mm = 450;
    Target walker = target("walker", TargetKind::rectangle, {90, 10, 170, 58}, 15);
    walker.width_mm = 30;
    Target base = target("base", TargetKind::bars, {20, 72, 470, 22}, 20);
    base.pitch_mm = 5;
    view.targets = {walker, base};
    return view;
}

class LabSessionTest : public testing::Test {
protected:
    void SetUp() override {
        folder_ = shared_data("lab-session");
        if (folder_.empty()) GTEST_SKIP() << missing_data("lab-session");
        std::ifstream{folder_ / "truth.json"} >> truth_;
    }

    /// Every frame is ok and within `rms_px` of the truth after removal of a constant. The constant is the
    /// target's place on the object, which is not in the session.
    void expect_within(const View& view, double rms_px) {
        const std::vector<test::Shot> movie = test::grey_movie(folder_ / (view.camera + ".mkv"));
        ASSERT_EQ(movie.size(), 300U);
        ViewTracker tracker{view};
        std::vector<std::vector<double>> errors(view.targets.size());
        std::vector<double> sds(view.targets.size());
        for (std::size_t i = 0; i < movie.size(); ++i) {
            const auto fixes = tracker.update(movie[i].view(), CameraTick{static_cast<std::int64_t>(i)});
            for (std::size_t k = 0; k < fixes.size(); ++k) {
                ASSERT_EQ(fixes[k].state, TrackState::ok) << view.targets[k].name << ", frame " << i;
                const auto key = "x_" + view.targets[k].name + "_mm_every_frame";
                const double mm = truth_.at(key).at(i).get<double>();
                errors[k].push_back(fixes[k].x_px -
                                    mm / calibration::mm_per_px_at(view, view.targets[k].offset_mm));
                sds[k] += fixes[k].sd_px / static_cast<double>(movie.size());
            }
        }
        for (std::size_t k = 0; k < errors.size(); ++k) {
            double mean = 0, sum = 0;
            for (const double e : errors[k]) mean += e / static_cast<double>(errors[k].size());
            for (const double e : errors[k]) sum += (e - mean) * (e - mean);
            const double rms = std::sqrt(sum / static_cast<double>(errors[k].size()));
            std::printf("%s %s: %.5f px rms, claimed %.5f px\n", view.camera.c_str(),
                        view.targets[k].name.c_str(), rms, sds[k]);
            EXPECT_LT(rms, rms_px) << view.targets[k].name;
            EXPECT_LT(rms, 2 * sds[k]) << view.targets[k].name;
        }
    }

    std::filesystem::path folder_;
    nlohmann::json truth_;
};

// Measured 0.003 px (walker) and 0.002 px (base); the goal is 0.01 px.
TEST_F(LabSessionTest, TopViewIsTrackedToAHundredthOfAPixel) { expect_within(top_view(), 0.01); }
TEST_F(LabSessionTest, SideViewIsTrackedToAHundredthOfAPixel) { expect_within(side_view(), 0.01); }

}  // namespace
}  // namespace shaker::tracking
