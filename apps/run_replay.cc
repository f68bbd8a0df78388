#include "run_replay.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <set>

#include "gluevo/nn/error.h"
#include "options/option_values.h"

namespace gluevo::apps {
namespace {

constexpr const char* kChecksumSuffix = "_sha256";

std::string ValueOf(const std::map<std::string, std::string>& values, const std::string& name) {
  const auto found = values.find(name);
  return found != values.end() ? found->second : "";
}

}  // namespace

vo::RunRecord MakeRunRecord(const CLI::App& command, const std::string& method,
                            const vo::Networks& networks) {
  vo::RunRecord record{method, {}, {}};
  for (const auto& [option, values] : OptionValues(command)) {
    record.options[option] = ValueText(values);
  }
  for (const vo::WeightsRecord& weights : networks.records) {
    record.weights[weights.network] = weights.source;
    record.weights[weights.network + kChecksumSuffix] = weights.checksum;
  }
  return record;
}

std::string ReplayedMethod(const CLI::App& command, const vo::MatchStoreReader& store) {
  const CLI::Option* const method = command.get_option("--method");
  const std::string& stored = store.record().method;
  if (method->count() > 0 && method->as<std::string>() != stored) {
    throw Error(store.path().string() + ": matches of method " + Quoted(stored) +
                ", --method asks for " + method->as<std::string>());
  }
  return stored;
}

void SelectReplayedFrames(const CLI::App& command, const vo::MatchStoreReader& store, int& start,
                          int& count, int& stride) {
  const std::pair<const char*, int*> selection[] = {
      {"start", &start}, {"count", &count}, {"stride", &stride}};
  // One given option already asks for other frames than the stored ones.
  if (std::any_of(std::begin(selection), std::end(selection), [&](const auto& entry) {
        return command.get_option("--" + std::string(entry.first))->count() > 0;
      })) {
    return;
  }
  for (const auto& [name, value] : selection) {
    const std::string text = ValueOf(store.record().options, name);
    std::from_chars(text.data(), text.data() + text.size(), *value);
  }
  const auto done = static_cast<int>(store.timestamps_ns().size() + store.left_out_ns().size());
  count = count < 0 ? done : std::min(count, done);
}

void LeaveOutReplayed(const vo::MatchStoreReader& store, vo::Dataset& dataset) {
  const std::set<int64_t> left_out(store.left_out_ns().begin(), store.left_out_ns().end());
  std::erase_if(dataset.entries, [&](const vo::Dataset::Entry& entry) {
    return left_out.contains(entry.timestamp_ns);
  });
}

std::vector<vo::WeightsRecord> ReplayedWeights(const vo::MatchStoreReader& store) {
  const auto& weights = store.record().weights;
  std::vector<vo::WeightsRecord> records;
  // In the order of the work.
  for (const std::string network : {"superpoint", "aliked", "superglue", "lightglue"}) {
    if (weights.contains(network)) {
      records.push_back(
          {network, weights.at(network), ValueOf(weights, network + kChecksumSuffix)});
    }
  }
  return records;
}

void AddReplayedWeights(const std::vector<vo::WeightsRecord>& more,
                        const std::filesystem::path& store,
                        std::vector<vo::WeightsRecord>& replayed) {
  for (const vo::WeightsRecord& record : more) {
    const auto stored =
        std::find_if(replayed.begin(), replayed.end(),
                     [&](const vo::WeightsRecord& one) { return one.network == record.network; });
    if (stored == replayed.end()) {
      replayed.push_back(record);
    } else if (stored->checksum != record.checksum) {
      throw Error(store.string() + ": matches by the " + record.network + " weights " +
                  Quoted(stored->source) + ", --loops would use " + Quoted(record.source) +
                  "; expected the same");
    }
  }
}

std::string ReplayedFeatures(const vo::MatchStoreReader& store) {
  const vo::RunRecord& record = store.record();
  const std::string features = ValueOf(record.options, "features");
  return record.method == "klt" ? "" : features.empty() ? "superpoint" : features;
}

std::string ReplayedMatcher(const vo::MatchStoreReader& store) {
  const vo::RunRecord& record = store.record();
  return record.method != "superglue"
             ? ""
             : vo::MatcherOf(ReplayedFeatures(store), ValueOf(record.options, "matcher"));
}

}  // namespace gluevo::apps
