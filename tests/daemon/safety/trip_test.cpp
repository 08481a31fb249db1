#include "daemon/safety/trip.hpp"

#include <gtest/gtest.h>

#include <set>
#include <type_traits>

namespace shaker::safety {
namespace {

static_assert(std::is_trivially_copyable_v<Trip>);

TEST(TripTest, EveryCauseHasUniqueNameAndText) {
    std::set<std::string> names;
    for (std::size_t i = 0; i < causes; ++i) {
        const auto cause = static_cast<Cause>(i);
        names.insert(name(cause));
        const std::string words = text({.cause = cause, .value = 0.123, .limit = 0.0456, .tick = 77});
        EXPECT_NE(words.find(name(cause)), std::string::npos) << words;
        EXPECT_NE(words.find("77"), std::string::npos) << words;
        EXPECT_EQ(words.find('{'), std::string::npos) << words;
        if (cause == Cause::sensor_not_finite || cause == Cause::operator_stop ||
            cause == Cause::abort_input || cause == Cause::mixer)
            continue;
        EXPECT_NE(words.find("12"), std::string::npos) << words;
        EXPECT_NE(words.find('4'), std::string::npos) << words;
    }
    EXPECT_EQ(names.size(), causes);
    EXPECT_STREQ(name(Cause::operator_stop), "operator_stop") << "words and causes in one order";
}

TEST(TripTest, TextHasUnitAndNextAction) {
    EXPECT_EQ(text({.cause = Cause::displacement,
                    .stop = StopKind::hard,
                    .on_dac_clock = true,
                    .value = 3.25e-3,
                    .limit = 3.2e-3,
                    .tick = 4800}),
              "the base is 3.25 mm from its mean position (limit 3.2 mm); lower gamma or raise the frequency "
              "(displacement: hard stop at DAC sample 4800)");
    EXPECT_NE(text({.cause = Cause::harmonic_band, .harmonic = 2, .value = 3.5, .limit = 3})
                  .find("harmonic 2 is 3.5 dB from its target (limit 3 dB)"),
              std::string::npos);
    EXPECT_STREQ(unit_of(Cause::acceleration), "m/s^2");
}

}  // namespace
}  // namespace shaker::safety
