// perp study SCENE --map A=LO:HI:N --map B=LO:HI:N: where methods are right, off, say so, or are silently absurd.
#include "cli/study_map.hpp"

#include <unistd.h>
#include <cstdio>
#include <map>

#include "cli/commands.hpp"
#include "perp/core/errors.hpp"
#include "perp/io/scene_file.hpp"
#include "perp/step/methods.hpp"

namespace perp {

int study_map(const AtlasRequest& request, const std::filesystem::path& folder) {
  for (const std::string& name : request.methods) (void)method(name);
  // the corners, so that a parameter that the scene does not have is refused before anything runs
  for (const AtlasAxis* axis : {&request.a, &request.b})
    if (axis->name == "h" && !(axis->low > 0))
      refuse("perp study", "--map", axis->name, "needs steps above 0 [s]");
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const std::vector<AtlasCell> cells = atlas(request, [&](int done, int all) {
    if (terminal) std::fprintf(stderr, "\r\033[K[%d/%d]", done, all);
  });
  if (terminal) std::fprintf(stderr, "\r\033[K");
  write_atlas(request, cells, folder);
  std::map<std::string, std::map<std::string_view, int>> counts;
  for (const AtlasCell& cell : cells) {
    ++counts[cell.method][name_of(cell.verdict)];
    ++counts[cell.method][name_of(cell.outcome)];
  }
  for (const std::string& name : request.methods) {
    std::printf("%s:", name.c_str());
    for (const char* word : {"right", "off", "said-so", "silent"})
      std::printf(" %d %s,", counts[name][word], word);
    for (const char* word : {"sticks", "slides", "jumps", "bounded", "grows", "unknown"})
      if (counts[name][word] > 0) std::printf(" %s %d", word, counts[name][word]);
    std::printf("\n");
  }
  std::printf("wrote map.csv and a map of each method to %s\n", folder.c_str());
  return Done;
}

}  // namespace perp
