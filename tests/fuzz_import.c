/* Fuzzing target for lensimport.h: any bytes through the readers, and what they accept through every later stage, which is
   fuzz.c's part. Built three ways, as that one is: with libFuzzer and with coverage (tests/fuzz_import.sh), and with a main of
   its own that replays files, each also mutated FUZZ_ROUNDS times (-DFUZZ_MAIN, tests/check_import.sh). With FUZZ_FORMAT=n in the
   environment other formats are passed over at once. */
#define LLVMFuzzerTestOneInput fuzz_lens
#define LLVMFuzzerCustomMutator fuzz_lens_mutator
#define LLVMFuzzerCustomCrossOver fuzz_lens_crossover
#define main fuzz_lens_main
#include "fuzz.c"
#undef LLVMFuzzerTestOneInput
#undef LLVMFuzzerCustomMutator
#undef LLVMFuzzerCustomCrossOver
#undef main
#define LENSIMPORT_IMPLEMENTATION
#include "lenses/lensimport.h"

#ifndef FUZZ_STAGES
#define FUZZ_STAGES 96 /* one accepted input in so many goes through all */
#endif

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed);

static void check_report(const lensimport_report *report)
{
    char text[200];
    int32_t i, k;
    CHECK(report->format != LENSIMPORT_UNKNOWN && report->config >= 1 && report->config <= report->config_count);
    CHECK(report->note_count >= 0 && report->note_count <= LENSIMPORT_MAX_NOTES);
    for (i = 0; i < report->note_count; i++) {
        lensimport_note_text(&report->notes[i], text, sizeof text);
        CHECK(report->notes[i].kind >= LENSIMPORT_NOTE_EFL_DIFFERS && report->notes[i].kind <= LENSIMPORT_NOTE_SENSOR_DERIVED && text[0] != 0);
        for (k = 0; text[k] != 0; k++) CHECK(text[k] >= 32 && text[k] < 127);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static lflare_prescription p, again;
    static lensimport_report report;
    static int only = -1;
    lensimport_desc desc;
    lflare_error error;
    lflare_result result;
    char *text;
    size_t length;
    rng r;
    r.state = hash(data, size);
    memset(&desc, 0, sizeof desc);
    desc.config = below(&r, 3) ? 0 : below(&r, 4);
    desc.focus = below(&r, 4) == 0;
    if (below(&r, 8) == 0) desc.catalogues = "CDGM OHARA";
    if (only < 0) only = getenv("FUZZ_FORMAT") != NULL ? atoi(getenv("FUZZ_FORMAT")) : 0;
    if (only > 0 && lensimport_sniff(data, size) != (lensimport_format)only) return -1;
    result = lensimport_read(data, size, &desc, &p, &report, &error);
    check_error(result, &error);
    CHECK((size_t)error.line <= size + 1 && error.line >= 0);
    if (result != LFLARE_OK) {
        CHECK(result == LFLARE_ERROR_SYNTAX || result == LFLARE_ERROR_LENS || result == LFLARE_ERROR_ARGUMENT);
        CHECK(report.refusal == LENSIMPORT_REFUSED_NOT || result == LFLARE_ERROR_LENS);
        inputs++;
        return 0;
    }
    check_report(&report);
    CHECK(lensimport_read(data, size, &desc, &again, NULL, NULL) == LFLARE_OK && memcmp(&p, &again, sizeof p) == 0);
    CHECK(p.surface_count > 0 && p.surface_count <= LFLARE_MAX_SURFACES);
    text = write_text(&p, &length);
    if (below(&r, FUZZ_STAGES) == 0) { /* the later stages take most of the time, and have a target of their own */
        fuzz_lens((const uint8_t *)text, length);
    } else if (lflare_text_read(text, length, &again, NULL) == LFLARE_OK) {
        static lflare_lens lens;
        lflare_lens_derive(&again, &lens, &error);
        check_same(&p, &again);
    }
    free(text);
    return 0;
}

/* Another number for one of the text's. */
static void change_any_number(const char *text, size_t size, rng *r, words *w)
{
    static const char *const odd[] = {"0", "1", "-1", "1e9", "1e10", "1e-3", "1e309", "nan", "Infinity", "inf", "INFINITY", "2", "3", ".5", "7.", "1.5", "1.67", "60", "100000", "-0.01", "0.02", "1e-300", "517642"};
    size_t at, end, tries;
    double v;
    for (tries = 0; tries < 64; tries++) {
        at = size > 0 ? (size_t)(next(r) % size) : 0;
        if (size == 0 || text[at] < '0' || text[at] > '9') continue;
        while (at > 0 && strchr("0123456789.eE+-", text[at - 1]) != NULL && text[at - 1] != 0) at--;
        for (end = at; end < size && text[end] != 0 && strchr("0123456789.eE+-", text[end]) != NULL; end++) {}
        put_bytes(w, text, at);
        if (below(r, 4) == 0 || !lflare_number_read(text + at, end - at, &v)) put(w, odd[below(r, (int32_t)(sizeof odd / sizeof *odd))]);
        else if (below(r, 8) == 0) put_number(w, -v);
        else put_number(w, v * (below(r, 2) ? between(r, 0.5, 2) : between(r, 0.95, 1.05)));
        put_bytes(w, text + end, size - end);
        return;
    }
    put_bytes(w, text, size);
}

/* Numbers, lines, words of the same text, and libFuzzer's own ways with its dictionary. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned int seed)
{
    enum { LINES = 600 };
    static size_t lines[LINES];
    static words a, b;
    rng r;
    int32_t times, n, i, k;
    r.state = seed;
#ifndef FUZZ_MAIN
    if (below(&r, 3) == 0 || size > sizeof a.bytes / 2) return LLVMFuzzerMutate(data, size, max_size);
#endif
    if (size > sizeof a.bytes / 2) return size;
    a.size = 0;
    put_bytes(&a, (const char *)data, size);
    for (times = 1 + below(&r, 4); times > 0; times--) {
        b.size = 0;
        n = find_lines(a.bytes, a.size, lines, LINES);
        i = below(&r, n);
        k = below(&r, n);
        switch (below(&r, 8)) {
        case 0: /* a line less */
            put_bytes(&b, a.bytes, lines[i]);
            put_bytes(&b, a.bytes + lines[i + 1], a.size - lines[i + 1]);
            break;
        case 1: /* a line again, elsewhere */
            put_bytes(&b, a.bytes, lines[k + 1]);
            put_bytes(&b, a.bytes + lines[i], lines[i + 1] - lines[i]);
            put_bytes(&b, a.bytes + lines[k + 1], a.size - lines[k + 1]);
            break;
        case 2: { /* some bytes in place of others */
            size_t at = a.size > 0 ? (size_t)(next(&r) % a.size) : 0, from = a.size > 0 ? (size_t)(next(&r) % a.size) : 0, length = 1 + (size_t)below(&r, 12);
            put_bytes(&b, a.bytes, a.size);
            if (at + length <= a.size && from + length <= a.size) memmove(b.bytes + at, a.bytes + from, length);
            break;
        }
        case 3: /* cut */
            put_bytes(&b, a.bytes, below(&r, 8) && a.size > 0 ? a.size - (size_t)(next(&r) % a.size) / 8 : a.size / 2);
            break;
        default: change_any_number(a.bytes, a.size, &r, &b); break;
        }
        a.size = 0;
        put_bytes(&a, b.bytes, b.size);
    }
    if (a.size > max_size) a.size = max_size;
    memcpy(data, a.bytes, a.size);
    return a.size;
}

#ifdef FUZZ_MAIN
int main(int argc, char **argv)
{
    const char *rounds_text = getenv("FUZZ_ROUNDS"), *dump = getenv("FUZZ_DUMP");
    int rounds = rounds_text != NULL ? atoi(rounds_text) : 0, i, k;
    for (i = 1; i < argc; i++) {
        static uint8_t original[4 * TEXT], buffer[4 * TEXT];
        size_t size, whole;
        uint8_t *exact;
        FILE *file = fopen(argv[i], "rb");
        if (file == NULL) {
            fprintf(stderr, "%s: cannot be opened\n", argv[i]);
            return 1;
        }
        size = whole = fread(original, 1, sizeof original, file);
        fclose(file);
        for (k = 0; k <= rounds; k++) {
            if (k % 4 <= 1) memcpy(buffer, original, size = whole);
            if (k > 0) size = LLVMFuzzerCustomMutator(buffer, size, sizeof buffer, (unsigned int)(i * 1000 + k));
            exact = (uint8_t *)malloc(size > 0 ? size : 1); /* so that a byte too far is seen */
            if (exact == NULL) return 1;
            memcpy(exact, buffer, size);
            if (dump != NULL && (file = fopen(dump, "wb")) != NULL) { /* the last one written is the one that failed */
                fwrite(exact, 1, size, file);
                fclose(file);
            }
            LLVMFuzzerTestOneInput(exact, size);
            free(exact);
        }
    }
    print_counts();
    return 0;
}
#endif
