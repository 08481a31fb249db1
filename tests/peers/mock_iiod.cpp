// The mock iiod at 127.0.0.1, fed with the pattern at 4 kHz, in a network of its own, and a command that sees
// it: mock_iiod COMMAND [ARGUMENT...]. Exits with the command's status; 77 when the kernel refuses the
// network.
#include "tests/support/command.hpp"
#include "tests/support/devices/iiod_pattern.hpp"

int main(int argc, char** argv) {
    using namespace shaker;
    constexpr std::uint16_t libiios_own_port = 30431;
    return test::run_among_mocks({argv, static_cast<std::size_t>(argc)}, {}, [](const auto& run_command) {
        // 4 s of samples: clients that this machine lets wait lose none.
        mock::Iiod iiod{mock::IiodDescription{.fifo = 16384}, libiios_own_port};
        const test::PatternFeeder feeder{iiod, iiod.rate_hz()};
        return run_command();
    });
}
