// The mock iiod at 127.0.0.1, which receives the pattern at 4 kHz, and a command in the same private network:
// mock_iiod COMMAND [ARGUMENT...]. Exits with the command's status; 77 when the kernel refuses the network.
#include "tests/support/command.hpp"
#include "tests/support/devices/iiod_pattern.hpp"

int main(int argc, char** argv) {
    using namespace shaker;
    constexpr std::uint16_t libiios_own_port = 30431;
    return test::run_among_mocks({argv, static_cast<std::size_t>(argc)}, {}, [](const auto& run_command) {
        // 4 s of samples, so that clients on a busy machine lose none.
        mock::Iiod iiod{mock::IiodDescription{.fifo = 16384}, libiios_own_port};
        const test::PatternFeeder feeder{iiod, iiod.rate_hz()};
        return run_command();
    });
}
