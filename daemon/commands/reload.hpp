#pragma once
// The settings files read again while the daemon runs: all of what they say is taken, or nothing.
#include "daemon/bench/bench.hpp"
#include "daemon/commands/serve_settings.hpp"
#include "daemon/remote/server.hpp"

namespace shaker::commands {

class Reload {
public:
    /// All outlive this. settings: what the daemon was started with.
    Reload(const ServeOptions& options, const ServeSettings& settings, const bench::Bench& bench,
           service::BenchPort& bench_port, remote::Server& server)
        : options_{options}, settings_{settings}, bench_{bench}, bench_port_{bench_port}, server_{server} {}

    /// Reads the files and orders their drive, periods, limits, token, names and page. The log of the bench
    /// reports the outcome. Refused while the bench is driven, without reading any file; for any error in the
    /// files; and for a change that needs a restart of the daemon (rig, scene, address, ports, folder of
    /// recordings, pictures, identification, closed loop, mains). Never throws.
    void read();

private:
    void require_same(const ServeSettings& now) const;

    ServeOptions options_;
    ServeSettings settings_;
    const bench::Bench& bench_;
    service::BenchPort& bench_port_;
    remote::Server& server_;
};

}  // namespace shaker::commands
