// SPDX-License-Identifier: Apache-2.0
// `terray query`: heights, rays and lines of sight, by the kernel that makes the pictures.
#include "terray/query.h"

#include <fmt/format.h>

#include <limits>
#include <memory>

#include "commands.h"
#include "info_text.h"
#include "names.h"
#include "options.h"
#include "output.h"
#include "parse.h"
#include "query_input.h"
#include "query_output.h"
#include "terray/process.h"
#include "terray/renderer.h"
#include "usage.h"

namespace terray::cli {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

struct QueryFlags {
    SourceOptions source;
    QueryOptions query;
    std::vector<std::string> arguments;
    std::string file, outputPath;
    bool json = false;
};

using Answer = Answers (*)(const Terrain&, const QueryOptions&, const std::vector<Record>&);

const Column kX{"x", {"lon", "longitude", "east", "easting"}};
const Column kY{"y", {"lat", "latitude", "north", "northing"}};

Place placeOf(const std::string& what, const Record& record, size_t at, bool withHeight) {
    Place place;
    place.x = parseNumber(what + " x", record[at]);
    place.y = parseNumber(what + " y", record[at + 1]);
    if (withHeight) parseHeight(what + " z", record[at + 2], place);
    return place;
}

std::string numbered(const char* what, size_t index) {
    return fmt::format("{} {}", what, index + 1);
}

Answers answerHeights(const Terrain& terrain, const QueryOptions& options,
                      const std::vector<Record>& records) {
    std::vector<Place> places;
    for (size_t k = 0; k < records.size(); ++k)
        places.push_back(placeOf(numbered("point", k), records[k], 0, false));
    const auto heights = valueOf(queryHeights(terrain, places, options));
    Answers answers{{"x", "y", "height"}, {}};
    for (size_t k = 0; k < places.size(); ++k)
        answers.rows.push_back({places[k].x, places[k].y, heights[k]});
    return answers;
}

Answers answerRays(const Terrain& terrain, const QueryOptions& options,
                   const std::vector<Record>& records) {
    std::vector<QueryRay> rays;
    for (size_t k = 0; k < records.size(); ++k) {
        const std::string what = numbered("ray", k);
        rays.push_back({placeOf(what, records[k], 0, true),
                        parseNumber(what + " heading", records[k][3]),
                        parseNumber(what + " pitch", records[k][4])});
    }
    const auto hits = valueOf(queryRays(terrain, rays, options));
    Answers answers{
        {"hit", "distance", "x", "y", "z", "normal_x", "normal_y", "normal_z", "from_below"}, {}};
    for (const QueryHit& h : hits) {
        if (h.hit)
            answers.rows.push_back(
                {true, h.distance, h.x, h.y, h.z, h.normalX, h.normalY, h.normalZ, h.fromBelow});
        else
            answers.rows.push_back({false, kNothing, kNothing, kNothing, kNothing, kNothing,
                                    kNothing, kNothing, kNothing});
    }
    return answers;
}

Answers answerSight(const Terrain& terrain, const QueryOptions& options,
                    const std::vector<Record>& records) {
    std::vector<Place> from, to;
    for (size_t k = 0; k < records.size(); ++k) {
        from.push_back(placeOf(numbered("line", k) + " from", records[k], 0, true));
        to.push_back(placeOf(numbered("line", k) + " to", records[k], 3, true));
    }
    const auto lines = valueOf(queryLinesOfSight(terrain, from, to, options));
    Answers answers{
        {"visible", "distance", "blocked_distance", "blocked_x", "blocked_y", "blocked_z"}, {}};
    for (const LineOfSight& l : lines) {
        const QueryHit& b = l.blockedAt;
        if (l.visible)
            answers.rows.push_back({true, l.distance, kNothing, kNothing, kNothing, kNothing});
        else
            answers.rows.push_back({false, l.distance, b.distance, b.x, b.y, b.z});
    }
    return answers;
}

void runQuery(const QueryFlags& flags, const std::vector<Column>& columns, Answer answer) {
    setQuiet(flags.source.quiet);
    if (flags.arguments.empty() && flags.file.empty())
        failUsage("query: nothing is asked; give places as arguments or --from FILE");
    const std::vector<Record> records = readRecords(flags.arguments, flags.file, columns);
    checkNotInput("--output", flags.outputPath, {flags.source.source, flags.file});
    if (!flags.outputPath.empty()) checkWritable("--output", flags.outputPath);
    OpenOptions open = flags.source.open;
    open.storedPhoto = false;  // numbers need none
    const Terrain terrain = valueOf(Terrain::open(flags.source.source, open));
    sayAssumptions(terrain.info());
    const Answers answers = answer(terrain, flags.query, records);
    const std::string text = flags.json ? answersJson(answers) : answersCsv(answers);
    if (flags.outputPath.empty())
        printOut(text);
    else
        writeTextFile("--output", flags.outputPath, text);
}

void addQueryOptions(CLI::App& command, QueryFlags& flags) {
    constexpr const char* kQuery = "Query";
    addText(command, kQuery, "--from", "FILE", "questions as CSV or JSON, '-' for standard input",
            [&flags](const std::string& text) { flags.file = text; });
    addText(command, kQuery, "-o,--output", "FILE", "where answers go (default: standard output)",
            [&flags](const std::string& text) { flags.outputPath = text; });
    addSwitch(command, kQuery, "--json", "answers as JSON (default: CSV)", flags.json);
    addSwitch(command, kQuery, "--lonlat", "X,Y are degrees of longitude and latitude",
              flags.query.lonLat);
    addText(command, kQuery, "--surface", "NAME", "bilinear (default) or constant",
            [&flags](const std::string& text) {
                flags.query.surface = parseName("--surface", text, kSurfaces);
            });
    addText(command, kQuery, "--curvature", "on|off", "of the globe (default: on with a CRS)",
            [&flags](const std::string& text) {
                flags.query.curvature = parseOnOff("--curvature", text);
            });
    addText(command, kQuery, "--refraction", "K", "of the air (default 0.13)",
            [&flags](const std::string& text) {
                flags.query.refraction = parseNumber("--refraction", text);
            });
}

void addQuestion(CLI::App& query, const std::shared_ptr<QueryFlags>& flags, const char* name,
                 const char* help, const char* value, const char* example,
                 std::vector<Column> columns, Answer answer) {
    CLI::App* question = query.add_subcommand(name, help);
    question->fallthrough();
    question->add_option("PLACES", flags->arguments, "questions, as many as you like")
        ->type_name(value);
    question->footer(example);
    question->callback(
        [flags, columns = std::move(columns), answer] { runQuery(*flags, columns, answer); });
}

}  // namespace

void addQuery(CLI::App& program) {
    auto flags = std::make_shared<QueryFlags>();
    CLI::App* query =
        program.add_subcommand("query", "heights, rays and lines of sight, as numbers");
    flags->source.addTo(*query);
    addQueryOptions(*query, *flags);
    query->require_subcommand(1);
    query->footer(
        "Examples:\n"
        "  terray query dem.tif height 500100,4200300 500200,4200300\n"
        "  terray query dem.tif ray 500100,4200300,+200,90,-5\n"
        "  terray query dem.tif line-of-sight 500100,4200300,+2,503000,4207000,+2\n"
        "  terray query dem.tif --lonlat --from points.csv --json height");
    addQuestion(*query, flags, "height", "metres, at places X,Y", "X,Y",
                "Example:\n  terray query dem.tif height 500100,4200300", {kX, kY}, answerHeights);
    addQuestion(
        *query, flags, "ray", "where a ray meets the ground; Z may be +H above the ground",
        "X,Y,Z,HEADING,PITCH", "Example:\n  terray query dem.tif ray 500100,4200300,+200,90,-5",
        {kX, kY, {"z", {"height"}, true}, {"heading", {"azimuth"}}, {"pitch", {}}}, answerRays);
    addQuestion(*query, flags, "line-of-sight",
                "whether one place sees another; an empty Z is the ground", "X,Y,Z,X,Y,Z",
                "Example:\n  terray query dem.tif line-of-sight "
                "500100,4200300,+2,503000,4207000,+2",
                {{"from_x", {}},
                 {"from_y", {}},
                 {"from_z", {}, false},
                 {"to_x", {}},
                 {"to_y", {}},
                 {"to_z", {}, false}},
                answerSight);
}

}  // namespace terray::cli
