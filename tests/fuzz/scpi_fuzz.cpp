// libFuzzer's entry to one client of the remote control: clang++ -fsanitize=fuzzer,address,undefined, with
// daemon/remote/scpi/*.cpp, drivers/quantity.cpp and tests/support/scpi_client.cpp.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tests/support/scpi_client.hpp"

// The first byte says how the others are cut, and whether the instrument is done in between.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace shaker;
    if (size == 0) return 0;
    static test::ScpiBench bench;
    test::ScpiClient client{bench};
    const std::size_t piece = 1U + (data[0] & 0x7fU);
    const bool patient = (data[0] & 0x80U) != 0;
    std::string_view rest{reinterpret_cast<const char*>(data) + 1, size - 1};
    while (!rest.empty()) {
        client.session.feed(rest.substr(0, piece));
        rest.remove_prefix(std::min(piece, rest.size()));
        if (patient) bench.instrument.busy = false;
        client.session.poll();
    }
    do {  // what was withheld may begin and wait again
        bench.instrument.busy = false;
        client.session.poll();
    } while (client.session.waiting());
    client.session.finish();
    const std::string_view output = client.session.output();
    if (!output.empty() && output.back() != '\n') std::abort();
    if (output.size() > scpi::Session::output_limit) std::abort();
    client.read();
    if (client.ask("*TST?") != "0\n") std::abort();
    bench.instrument.told.clear();
    return 0;
}
