#pragma once

// Headers name CLI11's command line only: including it compiles its whole parser once more.
namespace CLI {
class App;
}  // namespace CLI
