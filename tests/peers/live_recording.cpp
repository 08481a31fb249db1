// Records the series of a whole bench in real time: live_recording FILE SECONDS.
#include <cstdio>
#include <cstdlib>

#include "tests/support/remote/live_streams.hpp"

int main(int argc, char** argv) try {
    if (argc != 3) return 2;
    const shaker::test::LiveCost cost = shaker::test::record_live(argv[1], {.seconds = std::atof(argv[2])});
    std::printf("%llu pieces lost\n", static_cast<unsigned long long>(cost.lost));
    return cost.lost == 0 ? 0 : 1;
} catch (const std::exception& error) {
    std::fprintf(stderr, "live_recording: %s\n", error.what());
    return 1;
}
