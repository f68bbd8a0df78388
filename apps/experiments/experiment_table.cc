#include "experiment_table.h"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <set>

#include "experiment_figures.h"
#include "json_text.h"

namespace gluevo::apps {
namespace {

using Json = nlohmann::ordered_json;
using Status = RunOutcome::Status;

constexpr const char* kNothing = "-";

std::vector<Figure> FiguresForPrograms() {
  std::vector<Figure> figures(std::begin(kAccuracy), std::end(kAccuracy));
  figures.push_back(kWithinSegments);
  figures.insert(figures.end(), std::begin(kWork), std::end(kWork));
  figures.insert(figures.end(), std::begin(kLoops), std::end(kLoops));
  figures.insert(figures.end(), std::begin(kInertial), std::end(kInertial));
  figures.insert(figures.end(), std::begin(kForProgramsOnly), std::end(kForProgramsOnly));
  return figures;
}

// Null where there is none.
Json Value(const RunOutcome& outcome, const char* pointer) {
  const Json::json_pointer place(pointer);
  return outcome.metrics.is_object() && outcome.metrics.contains(place) ? outcome.metrics[place]
                                                                        : Json();
}

std::string ForPeople(const RunOutcome& outcome, const Figure& figure) {
  const Json value = Value(outcome, figure.pointer);
  if (!value.is_number()) {
    return kNothing;
  }
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", figure.decimals, figure.factor * value.get<double>());
  return text;
}

// "97 of 99"; behind it how many of the others were not declared.
std::string CorrectMotions(const RunOutcome& outcome) {
  const Json motions = Value(outcome, "/motions");
  const Json correct = Value(outcome, "/correct_motions");
  if (!motions.is_number() || !correct.is_number()) {
    return kNothing;
  }
  std::string text = correct.dump() + " of " + motions.dump();
  const Json within = Value(outcome, "/within_segments");
  if (within.is_object() && within.value("breaks", 0) > 0) {
    const int wrong = within.value("motions", 0) - within.value("correct_motions", 0);
    text += wrong > 0 ? ", " + std::to_string(wrong) + " undeclared" : "";
  }
  return text;
}

// The options that any run sweeps, in order of appearance.
std::vector<std::string> SweptNames(const std::vector<RunOutcome>& outcomes) {
  std::vector<std::string> names;
  for (const RunOutcome& outcome : outcomes) {
    for (const auto& [name, value] : outcome.run.swept) {
      if (std::find(names.begin(), names.end(), name) == names.end()) {
        names.push_back(name);
      }
    }
  }
  return names;
}

std::string SweptValue(const RunOutcome& outcome, const std::string& name) {
  for (const auto& [swept, value] : outcome.run.swept) {
    if (swept == name) {
      return value;
    }
  }
  return "";
}

std::string StatusName(Status status) {
  switch (status) {
    case Status::kDone:
      return "done";
    case Status::kKept:
      return "kept";
    case Status::kFailed:
      return "failed";
    case Status::kMissing:
      break;
  }
  return "missing";
}

std::vector<std::string> Notes(const std::vector<RunOutcome>& outcomes) {
  std::vector<std::string> notes;
  std::set<int> threads;
  for (const RunOutcome& outcome : outcomes) {
    if (const Json value = Value(outcome, "/threads"); value.is_number()) {
      threads.insert(value.get<int>());
    }
    if (outcome.status == Status::kFailed || outcome.status == Status::kMissing) {
      notes.push_back(outcome.run.Name() + ": " + StatusName(outcome.status) + ": " +
                      outcome.reason);
    }
    if (const Json failure = Value(outcome, "/evaluation_failure"); failure.is_string()) {
      notes.push_back(outcome.run.Name() + ": not evaluated: " + failure.get<std::string>());
    }
    if (const Json warnings = Value(outcome, "/warnings"); warnings.is_array()) {
      for (const Json& warning : warnings) {
        notes.push_back(outcome.run.Name() + ": " + warning.get<std::string>());
      }
    }
  }
  if (!threads.empty()) {
    std::string text = "Frames a second with ";
    for (const int count : threads) {
      text += (count == *threads.begin() ? "" : " or ") + std::to_string(count);
    }
    notes.push_back(text + (threads == std::set<int>{1} ? " thread a run" : " threads a run"));
  }
  return notes;
}

std::string EscapeMarkdown(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    escaped += c == '|' ? "\\|" : std::string(1, c);
  }
  return escaped;
}

std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) {
    return text;
  }
  std::string quoted = "\"";
  for (const char c : text) {
    quoted += c == '"' ? "\"\"" : std::string(1, c);
  }
  return quoted + '"';
}

}  // namespace

ExperimentTable MakeTable(const std::vector<RunOutcome>& outcomes) {
  const std::vector<std::string> swept = SweptNames(outcomes);
  const auto any_has = [&](const char* pointer, double above) {
    return std::any_of(outcomes.begin(), outcomes.end(), [&](const RunOutcome& outcome) {
      const Json value = Value(outcome, pointer);
      return value.is_number() && value.get<double>() > above;
    });
  };
  // Behind the figures of accuracy come the motions, and behind those what else the runs have.
  std::vector<Figure> before(std::begin(kAccuracy), std::end(kAccuracy));
  if (any_has("/resets", 0.0)) {
    before.push_back(kWithinSegments);
  }
  std::vector<Figure> behind(std::begin(kWork), std::end(kWork));
  if (any_has("/loops_closed", -1.0)) {
    behind.insert(behind.begin(), std::begin(kLoops), std::end(kLoops));
  }
  if (any_has("/imu/noise_factor/gyroscope", 0.0)) {
    behind.insert(behind.begin(), std::begin(kInertial), std::end(kInertial));
  }
  ExperimentTable table;
  table.header = {"data set", "method"};
  table.header.insert(table.header.end(), swept.begin(), swept.end());
  const auto add_titles = [&](const std::vector<Figure>& figures) {
    for (const Figure& figure : figures) {
      table.header.emplace_back(figure.title);
    }
  };
  add_titles(before);
  table.header.emplace_back("correct motions");
  add_titles(behind);
  for (const RunOutcome& outcome : outcomes) {
    std::vector<std::string> row = {outcome.run.data, outcome.run.method};
    for (const std::string& name : swept) {
      const std::string value = SweptValue(outcome, name);
      row.push_back(value.empty() ? kNothing : value);
    }
    const std::size_t first = row.size();
    for (const Figure& figure : before) {
      row.push_back(ForPeople(outcome, figure));
    }
    if (!outcome.HasResult()) {
      row[first] = StatusName(outcome.status);
    }
    row.push_back(CorrectMotions(outcome));
    for (const Figure& figure : behind) {
      row.push_back(ForPeople(outcome, figure));
    }
    table.rows.push_back(std::move(row));
  }
  table.notes = Notes(outcomes);
  return table;
}

std::string TableAsMarkdown(const std::string& title, const ExperimentTable& table) {
  std::string text = title.empty() ? "" : "# " + title + "\n\n";
  const auto add = [&](const std::vector<std::string>& cells) {
    for (const std::string& cell : cells) {
      text += "| " + EscapeMarkdown(cell) + ' ';
    }
    text += "|\n";
  };
  add(table.header);
  add(std::vector<std::string>(table.header.size(), "---"));
  for (const std::vector<std::string>& row : table.rows) {
    add(row);
  }
  text += '\n';
  for (const std::string& note : table.notes) {
    text += "- " + note + '\n';
  }
  return text;
}

std::string OutcomesAsCsv(const std::vector<RunOutcome>& outcomes) {
  const std::vector<std::string> swept = SweptNames(outcomes);
  const std::vector<Figure> figures = FiguresForPrograms();
  std::string text = "data,method";
  for (const std::string& name : swept) {
    text += ',' + CsvField(name);
  }
  text += ",status,reason,folder";
  for (const Figure& figure : figures) {
    text += std::string(",") + figure.name;
  }
  text += '\n';
  for (const RunOutcome& outcome : outcomes) {
    text += CsvField(outcome.run.data) + ',' + CsvField(outcome.run.method);
    for (const std::string& name : swept) {
      text += ',' + CsvField(SweptValue(outcome, name));
    }
    text += ',' + StatusName(outcome.status) + ',' + CsvField(outcome.reason) + ',' +
            CsvField(outcome.run.folder.string());
    for (const Figure& figure : figures) {
      const Json value = Value(outcome, figure.pointer);
      text += ',' + (value.is_number() ? value.dump() : "");
    }
    text += '\n';
  }
  return text;
}

std::string OutcomesAsJson(const std::string& title, const std::vector<RunOutcome>& outcomes) {
  Json json;
  json["title"] = title;
  json["runs"] = Json::array();
  for (const RunOutcome& outcome : outcomes) {
    Json entry;
    entry["data"] = outcome.run.data;
    entry["method"] = outcome.run.method;
    entry["swept"] = Json::object();
    for (const auto& [name, value] : outcome.run.swept) {
      entry["swept"][name] = value;
    }
    entry["options"] = outcome.run.options;
    entry["dataset"] = outcome.run.dataset.string();
    entry["folder"] = outcome.run.folder.string();
    entry["status"] = StatusName(outcome.status);
    entry["reason"] = outcome.reason;
    for (const Figure& figure : FiguresForPrograms()) {
      entry[figure.name] = Value(outcome, figure.pointer);
    }
    json["runs"].push_back(entry);
  }
  return JsonText(json);
}

}  // namespace gluevo::apps
