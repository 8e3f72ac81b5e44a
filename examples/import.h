/* Of flare, the command-line tool: lenses in any format that lenses/lensimport.h reads, and the commands about them. Included
   by flare.c alone, behind its complaints and options, whose functions it uses. */

static const char help_import[] =
    "  flare convert IN -o OUT.lens [--focus]\n"
    "      a prescription of any format known here (below) into lensflare's own; --focus: the sensor goes into focus. Says what was\n"
    "      guessed, changed or contradicts itself\n"
    "  flare check   FILE|FOLDER...\n"
    "      one line for each file: its focal length and what looks odd, or the line and the reason why it is no lens; status 2 if any\n"
    "      is none\n"
    "  flare glass   NAME|ND,VD [--catalogue MAKERS]\n"
    "      the glass of a name (N-BK7, BK7, NBK7_SCHOTT, 517642), or those nearest to an index and an Abbe number; SCHOTT, OHARA,\n"
    "      CDGM, or several, first or alone\n"
    "\n"
    "LENS is a file of any format known here, told by its content: lensflare's own, Zemax .zmx and prescription reports, CODE V\n"
    ".seq, PhotonsToPhotos Optical Bench, pbrt .dat, OpenLensFlare .xml, RealFlare .json, FlareSim .lens. --config K, with any\n"
    "command: its zoom state K, from 1.\n"
    "AX,AY: the light's angle right and up of the axis, degrees. Without --fov the frame is as wide as the lens's sensor;\n"
    "with it (degrees, vertical) the frame is that camera's. --radius: the lamp's angular radius (the sun: 4.65).\n"
    "Exit status: 0 done, 2 wrong use, unreadable input or failed output, 130 interrupted.\n";

static void print_help(FILE *file)
{
    fputs(help, file);
    print_help_edit(file);
    print_help_optimize(file);
    print_help_coatings(file);
    fputs(help_import, file);
}

static int lens_config;              /* --config: zoom state, 0 = the file's own */
static lensimport_report lens_report; /* of the lens last read */

/* Reads and derives; 0 and what is wrong in *error if it cannot be, with the line or without. */
static int import_file(const char *path, int focus, lflare_prescription *prescription, lflare_lens *lens, lflare_error *error)
{
    lensimport_desc desc;
    char *text;
    size_t size;
    lflare_result result;
    memset(&lens_report, 0, sizeof lens_report);
    memset(&desc, 0, sizeof desc);
    desc.config = lens_config;
    desc.focus = focus;
    errno = 0;
    result = lflare_file_read(path, NULL, NULL, &text, &size, error);
    if (result != LFLARE_OK) {
        if (errno != 0) sprintf(error->text, "%.150s", strerror(errno));
        return 0;
    }
    result = lensimport_read(text, size, &desc, prescription, &lens_report, error);
    if (result == LFLARE_OK) result = lflare_lens_derive(prescription, lens, error);
    free(text);
    if (result == LFLARE_OK) return 1;
    if (error->line == 0 && result != LFLARE_ERROR_ARGUMENT) error->line = error->column = 1;
    return 0;
}

static void import_complain(const char *path, const lflare_error *error)
{
    if (error->line == 0) complain("%s: %s", path, error->text);
    fprintf(stderr, "%s:%d:%d: %s\n", path, (int)error->line, (int)error->column, error->text);
    exit(2);
}

static void read_lens(const char *path, const lflare_paths *paths, lflare_lens *lens)
{
    static lflare_prescription prescription;
    lflare_error error;
    if (!import_file(path, 0, &prescription, lens, &error) || lflare_lens_paths(lens, paths, &error) != LFLARE_OK) import_complain(path, &error);
}

/* Sentences about the lens last read, those of its reading first; NULL beyond the last. */
static const char *lens_note(const lflare_lens *lens, int i, char *out, size_t size)
{
    if (i < lens_report.note_count) return lensimport_note_text(&lens_report.notes[i], out, size);
    i -= lens_report.note_count;
    return i < lens->note_count ? lflare_note_text(&lens->notes[i], out, size) : NULL;
}

static int command_convert(int argc, char **argv)
{
    static lflare_prescription prescription;
    static lflare_lens lens;
    options o = parse(argc, argv, " -o --focus ", 1);
    const char *path = o.operands[0], *note;
    lflare_error error;
    output *out;
    char *text, sentence[200];
    size_t size = 0;
    int i;
    if (o.out == NULL) complain("flare convert: say where the lens goes, with -o OUT.lens");
    if (!import_file(path, o.focus, &prescription, &lens, &error)) import_complain(path, &error);
    if (prescription.source[0] == 0) {
        const char *slash = strrchr(path, '/');
        sprintf(prescription.source, "converted from %.150s (%s)", slash != NULL ? slash + 1 : path, lensimport_format_name(lens_report.format));
    }
    lflare_text_write(&prescription, NULL, &size);
    text = (char *)allocate(size, 1);
    lflare_text_write(&prescription, text, &size);
    out = output_open(o.out);
    fwrite(text, 1, size, out->file);
    for (i = 0; i < lens_report.note_count; i++) fprintf(out->file, "# %s\n", lensimport_note_text(&lens_report.notes[i], sentence, sizeof sentence));
    output_close(out);
    free(text);
    printf("%s: %s, %d surfaces, EFL %.4f mm, BFD %.4f mm, f/%.3g\n", o.out, lensimport_format_name(lens_report.format), (int)lens.surface_count, lens.efl, lens.bfd, lens.fnumber);
    for (i = 0; (note = lens_note(&lens, i, sentence, sizeof sentence)) != NULL; i++) printf("note      %s\n", note);
    return finish();
}

/* ---- flare check ---- */

/* What a reader of the one line wants to know beside the numbers. */
static int check_worth(const lensimport_note *note)
{
    switch (note->kind) {
    case LENSIMPORT_NOTE_EFL_DIFFERS: case LENSIMPORT_NOTE_FNUMBER_GUESSED: case LENSIMPORT_NOTE_CONFIG_PARTLY: case LENSIMPORT_NOTE_STOP_GUESSED: case LENSIMPORT_NOTE_STOP_MOVED:
    case LENSIMPORT_NOTE_SEMI_IGNORED: case LENSIMPORT_NOTE_OBJECT_FINITE: case LENSIMPORT_NOTE_ENDS_IN_GLASS: case LENSIMPORT_NOTE_GAP_MISSING: case LENSIMPORT_NOTE_RADIUS_DIFFERS: return 1;
    default: return 0;
    }
}

static int check_file(const char *path)
{
    static lflare_prescription prescription;
    static lflare_lens lens;
    lflare_error error;
    char text[200];
    int i, reduced = 0, crossing = 0;
    if (!import_file(path, 0, &prescription, &lens, &error)) {
        if (error.line > 0) printf("%s:%d:%d: %s\n", path, (int)error.line, (int)error.column, error.text);
        else printf("%s: %s\n", path, error.text);
        return 0;
    }
    printf("%s: ok, %s, %d surfaces, EFL %.4f mm, BFD %.4f mm, f/%.3g", path, lensimport_format_name(lens_report.format), (int)lens.surface_count, lens.efl, lens.bfd, lens.fnumber);
    if (lens_report.config_count > 1) printf(", state %d of %d", (int)lens_report.config, (int)lens_report.config_count);
    for (i = 0; i < lens_report.note_count; i++)
        if (check_worth(&lens_report.notes[i])) printf("; %s", lensimport_note_text(&lens_report.notes[i], text, sizeof text));
    for (i = 0; i < lens.note_count; i++) {
        reduced += lens.notes[i].kind == LFLARE_NOTE_SEMI_REDUCED;
        crossing += lens.notes[i].kind == LFLARE_NOTE_EDGES_CROSS;
        if (lens.notes[i].kind == LFLARE_NOTE_OUT_OF_FOCUS) printf("; %s", lflare_note_text(&lens.notes[i], text, sizeof text));
    }
    if (reduced > 0) printf("; semi-diameters beyond the surface's end: %d", reduced);
    if (crossing > 0) printf("; edges that cross: %d", crossing);
    printf("\n");
    return 1;
}

static int by_name(const void *a, const void *b) { return strcmp(*(char *const *)a, *(char *const *)b); }

/* A file, or all in a folder and those below it, by name. Returns how many fail. */
static int check_path(const char *path)
{
    DIR *folder = opendir(path);
    struct dirent *entry;
    char **names = NULL;
    size_t count = 0, i;
    int failed = 0;
    if (folder == NULL) return !check_file(path);
    while ((entry = readdir(folder)) != NULL) {
        if (entry->d_name[0] == '.') continue;
        names = (char **)realloc(names, (count + 1) * sizeof *names);
        if (names == NULL) complain("out of memory");
        names[count] = (char *)allocate(strlen(path) + strlen(entry->d_name) + 2, 1);
        sprintf(names[count++], "%s/%s", path, entry->d_name);
    }
    closedir(folder);
    if (count > 0) qsort(names, count, sizeof *names, by_name);
    for (i = 0; i < count; i++) {
        failed += check_path(names[i]);
        free(names[i]);
    }
    free(names);
    return failed;
}

static int command_check(int argc, char **argv)
{
    int i, files = 0, failed = 0, only_files = 0;
    for (i = 2; i < argc; i++) {
        if (!only_files && strcmp(argv[i], "--") == 0) { only_files = 1; continue; }
        if (!only_files && strcmp(argv[i], "--config") == 0) {
            if (++i == argc) complain("--config: a value is missing");
            lens_config = whole_number("--config", argv[i], 0, 1000);
            continue;
        }
        if (!only_files && argv[i][0] == '-') complain("unknown option '%s' for 'flare check'; see flare --help", argv[i]);
        files++;
        failed += check_path(argv[i]);
    }
    if (files == 0) complain("'flare check' needs files or folders; see flare --help");
    finish();
    return failed > 0 ? 2 : 0;
}

/* ---- flare glass ---- */

static void print_medium(const lflare_medium *m)
{
    int i;
    if (m->kind == LFLARE_MEDIUM_SELLMEIER) {
        printf("sellmeier");
        for (i = 0; i < 6; i++) {
            printf(" ");
            print_number(m->c[i]);
        }
    } else {
        printf(m->kind == LFLARE_MEDIUM_CONSTANT ? "n " : "nd ");
        print_number(m->c[0]);
        if (m->kind == LFLARE_MEDIUM_ABBE) {
            printf(" vd ");
            print_number(m->c[1]);
        }
    }
    if (m->glass[0] != 0) printf(" glass %s", m->glass);
}

static void print_glass(const lensimport_glass *g, const char *how)
{
    printf("name      %s\nmaker     %s\nnd        %.5f\n", g->name, g->maker[0] != 0 ? g->maker : "-", g->nd);
    if (g->vd > 0) printf("vd        %.2f\nmedium    ", g->vd);
    else printf("vd        not known\nmedium    ");
    print_medium(&g->medium);
    printf("\nmatch     %s\n", how);
}

static int command_glass(int argc, char **argv)
{
    static const char *const how[] = {"", "the catalogue's name", "nd and Vd alone are known", "the name it bears today", "its code", "no glass has this code: nd and Vd from its digits"};
    static const char *const makers[] = {NULL, "SCHOTT", "OHARA", "CDGM"};
    options o = parse(argc, argv, " --catalogue ", 1);
    const char *name = o.operands[0], *comma = strchr(name, ',');
    lensimport_glass g;
    double nd, vd, distance;
    int i;
    if (comma == NULL) {
        lensimport_match match = lensimport_glass_find(name, strlen(name), o.catalogue, &g);
        if (match == LENSIMPORT_MATCH_NONE) complain("no glass is known by the name '%s'", name);
        print_glass(&g, how[match]);
        return finish();
    }
    two_numbers("flare glass", name, ',', 1, 200, &nd, &vd);
    if (nd > 5) complain("flare glass: an index of refraction and an Abbe number were expected, not '%s'", name);
    for (i = 0; i < 4; i++) {
        char text[64];
        if (o.catalogue != NULL && i > 0) break;
        distance = lensimport_glass_nearest(nd, vd, i == 0 ? o.catalogue : makers[i], &g);
        if (!(distance < 1e9)) complain("no glass of '%s' is known", o.catalogue);
        sprintf(text, "nd %+.5f, Vd %+.2f from what was asked", g.nd - nd, g.vd - vd);
        if (i == 0) print_glass(&g, text);
        else printf("nearest   %s %s: nd %.5f, vd %.2f\n", g.maker, g.name, g.nd, g.vd);
    }
    return finish();
}
