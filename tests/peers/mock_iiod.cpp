// The mock iiod alone, fed with the pattern at 4 kHz, until its standard input ends: what stock clients are
// pointed at. Prints its port, and at the end what it counted.
#include <cstdio>
#include <iostream>
#include <string>

#include "tests/support/iiod_pattern.hpp"

int main() {
    using namespace shaker;
    Iiod iiod{IiodDescription{.fifo = 16384}};
    {
        const test::PatternFeeder feeder{iiod, iiod.rate_hz()};
        std::printf("%d\n", iiod.port());
        std::fflush(stdout);
        std::string line;
        while (std::getline(std::cin, line)) {
        }
    }
    const IiodCounts counts = iiod.counts();
    std::printf("pushed %llu served %llu overflowed %llu\n", static_cast<unsigned long long>(counts.pushed),
                static_cast<unsigned long long>(counts.served),
                static_cast<unsigned long long>(counts.overflowed));
}
