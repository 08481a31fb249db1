// Data that arrive faster than they are written are lost and counted in the file.
#include "daemon/recording/recorder.hpp"

#include <gtest/gtest.h>

#include "daemon/recording/tables/places.hpp"
#include "drivers/errors.hpp"
#include "tests/support/program.hpp"
#include "tests/support/recording/small_recording.hpp"

namespace shaker::recording {

using namespace test;
namespace {

recorded::RecordingHeader header() {
    recorded::RecordingHeader h = test::small_header();
    h.pictures = recorded::KeptPictures::off;
    h.groups = recording_places(h, false);
    return h;
}

TEST(RecorderTest, LostPiecesAreCountedInTheFile) {
    const std::filesystem::path file = test::fresh_folder() / "run.nxs";
    constexpr std::int64_t plays = 70000;
    Recorder recording{file, header(), {.live = true}};
    for (std::int64_t n = 0; n < plays; ++n)
        recording.add(PlayTime{{n}, HostTime{std::chrono::nanoseconds{20000 * n}}});
    EXPECT_GT(recording.backlog(), 0.99);
    EXPECT_FALSE(recording.failure());
    recording.finish(acquisition::Streams{});
    const recorded::RecordingReader read{file};
    const std::size_t kept = read.play_times().size();
    EXPECT_GT(kept, 65000U);
    EXPECT_LT(kept, static_cast<std::size_t>(plays));
    EXPECT_EQ(static_cast<double>(kept) + read.scalar("process/pieces_lost"), plays);
    EXPECT_EQ(read.damage(), std::vector<std::string>{});
}

TEST(RecorderTest, DoesNothingWithoutFile) {
    Recorder recording{{}, header(), {}};
    recording.add(PlayTime{{7}, {}});
    EXPECT_FALSE(recording.on());
    EXPECT_FALSE(recording.step());
    recording.finish(acquisition::Streams{});
}

TEST(RecorderTest, FullDiskIsRefusedWithFigures) {
    const std::filesystem::path file = test::fresh_folder() / "run.nxs";
    try {
        Recorder recording{file, header(), {.least_free_bytes = std::uint64_t{1} << 60U}};
        FAIL() << "the recording was started";
    } catch (const InputError& e) {
        test::expect_in(e.what(), {"run.nxs", "free", "1152921504.61 GB"});
    }
    EXPECT_FALSE(std::filesystem::exists(file.string() + ".part"));
}

TEST(RecorderTest, DiskWithoutSpaceForFirstPicturesIsRefused) {
    const std::filesystem::path folder = test::fresh_folder();
    const RecorderSettings nearly_full{.least_free_bytes =
                                           std::filesystem::space(folder).available - (1U << 28U)};
    EXPECT_NO_THROW(Recorder(folder / "positions.nxs", header(), nearly_full));
    recorded::RecordingHeader pictures = header();
    ASSERT_EQ(pictures.views.size(), 2U);
    pictures.pictures = recorded::KeptPictures::region;
    try {
        Recorder recording{folder / "pictures.nxs", pictures, nearly_full};
        FAIL() << "the recording was started";
    } catch (const InputError& e) {
        test::expect_in(e.what(), {"pictures.nxs", "must stay free, and the first pictures take 1.02 GB"});
    }
}

}  // namespace
}  // namespace shaker::recording
