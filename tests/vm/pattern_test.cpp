#include "tests/vm/pattern.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <vector>

#include "drivers/errors.hpp"
#include "tests/vm/heard_drive.hpp"

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
    [[nodiscard]] DriveFound found(const std::vector<std::int32_t>& drive) const {
        return find_drive(path_, 24, drive);
    }

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

std::vector<std::int32_t> drive_with_a_stop() {
    std::vector<std::int32_t> codes(3000);
    for (std::size_t i = 0; i < 2000; ++i)
        codes[i] = static_cast<std::int32_t>(1e6 * std::sin(0.0131 * static_cast<double>(i + 1))) * 256;
    return codes;
}

TEST(HeardDriveTest, SkippedStretchIsCounted) {
    const std::vector<std::int32_t> drive = drive_with_a_stop();
    std::vector<std::int32_t> heard(100);
    heard.insert(heard.end(), drive.begin(), drive.begin() + 700);
    heard.insert(heard.end(), drive.begin() + 1000, drive.end());
    const DriveFound found = Recorder{heard}.found(drive);
    EXPECT_EQ(found.exact, 1700);
    EXPECT_EQ(found.pieces, 2);
    EXPECT_EQ(found.skipped, 300);
    EXPECT_EQ(found.foreign, 0);
}

TEST(HeardDriveTest, ChangedSamplesAreForeign) {
    const std::vector<std::int32_t> drive = drive_with_a_stop();
    std::vector<std::int32_t> heard = drive;
    heard[500] += 256;
    heard[2500] = 256;
    const DriveFound found = Recorder{heard}.found(drive);
    EXPECT_EQ(found.exact, 1999);
    EXPECT_EQ(found.foreign, 2);
}

TEST(HeardDriveTest, CodesAreReadAsWritten) {
    const std::string path = testing::TempDir() + "codes.raw";
    write_codes(path, drive_with_a_stop());
    EXPECT_EQ(read_codes(path), drive_with_a_stop());
    std::filesystem::remove(path);
    EXPECT_THROW(read_codes(path), InputError);
}

}  // namespace
