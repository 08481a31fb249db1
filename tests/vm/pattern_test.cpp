#include "tests/vm/pattern.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "drivers/errors.hpp"

namespace {

using namespace shaker;
constexpr std::int64_t frames = 5000;

// A recording of 24-bit codes in the upper bytes of 32 bits: the first channel as given, the second at zero.
class Recorder {
public:
    explicit Recorder(const std::vector<std::int32_t>& samples)
        : path_{testing::TempDir() + testing::UnitTest::GetInstance()->current_test_info()->name() + ".raw"} {
        std::ofstream file{path_, std::ios::binary};
        for (const std::int32_t sample : samples) {
            const std::int32_t frame[] = {sample, 0};
            file.write(reinterpret_cast<const char*>(frame), sizeof frame);
        }
    }
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;
    ~Recorder() { std::filesystem::remove(path_); }
    [[nodiscard]] PatternFound found() const { return find_pattern(path_, 24, frames); }

private:
    std::string path_;
};

void append(std::vector<std::int32_t>& samples, std::int64_t from, std::int64_t to) {
    for (std::int64_t n = from; n < to; ++n) samples.push_back(pattern_code(n, 24) * 256);
}

TEST(PatternTest, PatternAfterSilenceIsOnePiece) {
    std::vector<std::int32_t> samples(777);
    append(samples, 0, frames);
    const PatternFound found = Recorder{samples}.found();
    EXPECT_EQ(found.exact, frames);
    EXPECT_EQ(found.pieces, 1);
    EXPECT_EQ(found.longest, frames);
    EXPECT_EQ(found.skipped + found.repeated + found.foreign, 0);
}

TEST(PatternTest, OmittedAndRepeatedSamplesAreCounted) {
    std::vector<std::int32_t> samples;
    append(samples, 0, 1000);
    append(samples, 3000, frames);
    append(samples, 500, 600);
    const PatternFound found = Recorder{samples}.found();
    EXPECT_EQ(found.exact, frames - 2000);
    EXPECT_EQ(found.pieces, 2);
    EXPECT_EQ(found.skipped, 2000);
    EXPECT_EQ(found.repeated, 100);
    EXPECT_EQ(found.foreign, 0);
}

TEST(PatternTest, OneWrongBitMakesSampleForeign) {
    std::vector<std::int32_t> samples;
    append(samples, 0, frames);
    samples[2000] ^= 1;  // below the 24 bits
    samples[3000] ^= 1 << 30;
    const PatternFound found = Recorder{samples}.found();
    EXPECT_EQ(found.foreign, 2);
    EXPECT_EQ(found.exact, frames - 2);
    EXPECT_EQ(found.skipped, 2);
}

TEST(PatternTest, MissingRecordingIsAnError) {
    EXPECT_THROW(find_pattern("/nowhere/at/all.raw", 16, frames), InputError);
}

}  // namespace
