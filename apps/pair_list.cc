#include "pair_list.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/io/whole_file.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct Line {
  int number = 0;
  std::string text;
};

std::vector<Line> ReadLines(const fs::path& path) {
  std::string text = vo::ReadWholeFile(path);
  if (text.find('\0') != std::string::npos) {
    const bool is_utf16 =
        text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") || text.find('\0') < 2;
    throw Error(path.string() + (is_utf16 ? ": text in UTF-16, expected UTF-8: save it as UTF-8"
                                          : ": no list of pairs: it holds zero bytes"));
  }
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) {
    text.erase(0, kByteOrderMark.size());
  }
  std::vector<Line> lines;
  int number = 1;
  for (std::size_t begin = 0; begin < text.size(); ++number) {
    const std::size_t end = std::min(text.find_first_of("\r\n", begin), text.size());
    const std::size_t first = text.find_first_not_of(" \t", begin);
    if (first < end && text[first] != '#') {
      lines.push_back({number, text.substr(begin, end - begin)});
    }
    begin = end + (text.compare(end, 2, "\r\n") == 0 ? 2 : 1);
  }
  return lines;
}

std::string Trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  return begin == std::string::npos ? ""
                                    : text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> fields;
  std::istringstream stream(text);
  for (std::string field; std::getline(stream, field, separator);) {
    fields.push_back(Trimmed(field));
  }
  return fields;
}

std::vector<std::string> Words(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

/// Finds the names of images as lists give them: as they are, without what stands before them
/// there ("./", the folder of the images), or with backslashes.
class Names {
 public:
  explicit Names(const std::vector<std::string>& images) : images_(images) {
    for (const std::string& image : images_) {
      for (std::size_t slash = image.find('/'); slash != std::string::npos;
           slash = image.find('/', slash + 1)) {
        ends_.emplace(image.substr(slash + 1), image);
      }
      ends_.emplace(image, image);
    }
  }

  /// Nothing where there are no features of such an image, or of several that may be meant.
  std::optional<std::string> Find(const std::string& listed) const {
    if (std::binary_search(images_.begin(), images_.end(), listed)) {
      return listed;
    }
    std::string name = listed;
    std::replace(name.begin(), name.end(), '\\', '/');
    name = fs::path(name).lexically_normal().generic_string();
    // The longest end of the name that is an image.
    for (std::string_view rest = name; !rest.empty();) {
      if (std::binary_search(images_.begin(), images_.end(), rest)) {
        return std::string(rest);
      }
      const std::size_t slash = rest.find('/');
      rest = slash == std::string_view::npos ? std::string_view() : rest.substr(slash + 1);
    }
    const std::vector<std::string> ending = EndingIn(name);
    return ending.size() == 1 ? std::optional(ending.front()) : std::nullopt;
  }

  /// The images of which the listed name is the end: of several none is found.
  std::vector<std::string> EndingIn(const std::string& listed) const {
    std::string name = listed;
    std::replace(name.begin(), name.end(), '\\', '/');
    const auto [first, last] =
        ends_.equal_range(fs::path(name).lexically_normal().generic_string());
    std::vector<std::string> images;
    std::transform(first, last, std::back_inserter(images),
                   [](const auto& end) { return end.second; });
    return images;
  }

 private:
  const std::vector<std::string>& images_;
  std::multimap<std::string, std::string> ends_;
};

using Pair = std::pair<std::string, std::string>;

// What stands between quotes on a line that begins with one.
std::vector<std::string> QuotedNames(const std::string& text) {
  std::vector<std::string> names;
  const std::string line = Trimmed(text);
  const char quote = line.empty() ? ' ' : line.front();
  if (quote != '"' && quote != '\'') {
    return names;
  }
  for (std::size_t begin = 0; begin != std::string::npos;) {
    const std::size_t end = line.find(quote, begin + 1);
    if (end == std::string::npos) {
      break;
    }
    names.push_back(line.substr(begin + 1, end - begin - 1));
    begin = line.find(quote, end + 1);
  }
  return names;
}

// The two names of a line as they are listed: of names with blanks, those that have features.
std::optional<Pair> NamesOfLine(const std::string& text, const Names& names) {
  if (const std::vector<std::string> quoted = QuotedNames(text); quoted.size() >= 2) {
    return Pair{quoted[0], quoted[1]};
  }
  for (const char separator : {'\t', ',', ';'}) {
    const std::vector<std::string> fields = Split(text, separator);
    if (fields.size() >= 2 && !fields[0].empty() && !fields[1].empty() &&
        (separator == '\t' || names.Find(fields[0]) || Words(text).size() < 2)) {
      return Pair{fields[0], fields[1]};
    }
  }
  const std::vector<std::string> words = Words(text);
  if (words.size() < 2) {
    return std::nullopt;
  }
  std::string first;
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    first += (i == 0 ? "" : " ") + words[i];
    std::string second;
    for (std::size_t j = i + 1; j < words.size() && names.Find(first); ++j) {
      second += (j == i + 1 ? "" : " ") + words[j];
      if (names.Find(second)) {
        return Pair{first, second};
      }
    }
  }
  return Pair{words[0], words[1]};
}

std::string WhyNotFound(const Names& names, const std::string& name) {
  const std::vector<std::string> meant = names.EndingIn(name);
  return meant.size() < 2 ? " has no features"
                          : " may be " + Quoted(meant[0]) + " or " + Quoted(meant[1]) +
                                (meant.size() > 2 ? " or another one" : "");
}

std::string Place(const fs::path& path, const Line& line) {
  return path.string() + ":" + std::to_string(line.number);
}

// As a file of matches names it.
std::string PlaceInFile(const Pair& pair) {
  std::string place = pair.first + '/' + pair.second;
  std::replace(place.begin(), place.begin() + static_cast<std::ptrdiff_t>(pair.first.size()), '/',
               '-');
  std::replace(place.begin() + static_cast<std::ptrdiff_t>(pair.first.size()) + 1, place.end(), '/',
               '-');
  return place;
}

}  // namespace

PairList ReadPairList(const fs::path& path, const std::vector<std::string>& images) {
  const Names names(images);
  PairList list;
  std::map<std::string, Pair> places;
  std::set<std::string> missing;
  std::string first_missing;
  for (const Line& line : ReadLines(path)) {
    const std::optional<Pair> listed = NamesOfLine(line.text, names);
    if (!listed) {
      throw Error(Place(path, line) + ": expected two names, \"name0 name1\"");
    }
    const std::optional<std::string> name0 = names.Find(listed->first);
    const std::optional<std::string> name1 = names.Find(listed->second);
    for (const auto& [found, name] : {std::pair{name0, listed->first}, {name1, listed->second}}) {
      if (!found && missing.insert(name).second && missing.size() == 1) {
        first_missing = Place(path, line) + ": " + Quoted(name) + WhyNotFound(names, name);
      }
    }
    if (!name0 || !name1) {
      continue;
    }
    const Pair pair{*name0, *name1};
    list.renamed += pair == *listed ? 0 : 1;
    const auto [place, is_new] = places.emplace(PlaceInFile(pair), pair);
    if (is_new) {
      list.pairs.push_back(pair);
    } else if (place->second == pair) {
      ++list.repeated;
    } else {
      throw Error(Place(path, line) + ": the pair " + Quoted(listed->first + " " + listed->second) +
                  " has the same place in a file of matches (slashes are dashes there) as " +
                  Quoted(place->second.first + " " + place->second.second));
    }
  }
  if (!missing.empty()) {
    throw Error(
        first_missing +
        (missing.size() == 1
             ? std::string()
             : "; so it is with " + vo::Counted(missing.size() - 1, "other") + " of the list") +
        "; nothing was matched");
  }
  if (list.pairs.empty()) {
    throw Error(path.string() + ": no pairs");
  }
  return list;
}

}  // namespace gluevo::apps
