/* The prescription format: messages with their places, round trips, numbers, what is derived, prescriptions made by hand.
   Run from the root of the repository. */
#define LENSFLARE_IMPLEMENTATION
#include "lensflare.h"

#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- broken prescriptions ---- */

typedef struct broken {
    const char *title, *text;
    size_t size;
    lflare_result code;
    int32_t line, column;
    const char *message;
} broken;

#define T(s) s, sizeof s - 1

/* Headers and rows are written out, so that lines and columns can be counted by eye. Columns count bytes. */
static const broken broken_texts[] = {
    {"empty", T(""),
     LFLARE_ERROR_SYNTAX, 1, 1, "the text is empty; it should begin with 'lensflare 1'"},
    {"blank lines and comments only", T("\n  \n# nothing\n"),
     LFLARE_ERROR_SYNTAX, 4, 1, "the text is empty; it should begin with 'lensflare 1'"},
    {"missing header", T("50 3 n 1.5\n"),
     LFLARE_ERROR_SYNTAX, 1, 1, "the first statement must be 'lensflare 1', not '50'"},
    {"header misspelt", T("lensflar 1\n"),
     LFLARE_ERROR_SYNTAX, 1, 1, "the first statement must be 'lensflare 1', not 'lensflar'"},
    {"header in capitals", T("Lensflare 1\n"),
     LFLARE_ERROR_SYNTAX, 1, 1, "the first statement must be 'lensflare 1', not 'Lensflare'"},
    {"version 2", T("lensflare 2\n"),
     LFLARE_ERROR_SYNTAX, 1, 11, "this reader knows version 1 of the format, not '2'"},
    {"version is no number", T("lensflare one\n"),
     LFLARE_ERROR_SYNTAX, 1, 11, "this reader knows version 1 of the format, not 'one'"},
    {"version missing", T("lensflare\n50 3\n"),
     LFLARE_ERROR_SYNTAX, 1, 10, "the version is missing: write 'lensflare 1'"},
    {"word after the version", T("lensflare 1 2\n"),
     LFLARE_ERROR_SYNTAX, 1, 13, "'2' is one word too many"},
    {"header twice", T("lensflare 1\nlensflare 1\n"),
     LFLARE_ERROR_SYNTAX, 2, 1, "'lensflare' is given twice"},
    {"byte order mark, error on line 1", T("\xef\xbb\xbflensflare 3\n"),
     LFLARE_ERROR_SYNTAX, 1, 11, "this reader knows version 1 of the format, not '3'"},
    {"UTF-16 little endian", T("\xff\xfel\0e\0n\0s\0"),
     LFLARE_ERROR_SYNTAX, 1, 1, "the text is UTF-16: save it as UTF-8"},
    {"UTF-16 big endian", T("\xfe\xff\0l\0e\0n\0s"),
     LFLARE_ERROR_SYNTAX, 1, 1, "the text is UTF-16: save it as UTF-8"},
    {"UTF-16 without a mark", T("l\0e\0n\0s\0f\0"),
     LFLARE_ERROR_SYNTAX, 1, 2, "a zero byte: this is not a text (or it is UTF-16: save it as UTF-8)"},
    {"NUL byte", T("lensflare 1\n50 3\0n 1.5\n"),
     LFLARE_ERROR_SYNTAX, 2, 5, "a zero byte: this is not a text (or it is UTF-16: save it as UTF-8)"},
    {"NUL byte in a comment", T("lensflare 1\n# a\0\n"),
     LFLARE_ERROR_SYNTAX, 2, 4, "a zero byte: this is not a text (or it is UTF-16: save it as UTF-8)"},
    {"control character", T("lensflare 1\n50\b3\n"),
     LFLARE_ERROR_SYNTAX, 2, 3, "a control character"},
    {"escape in a name", T("lensflare 1\nname \033[31m\n"),
     LFLARE_ERROR_SYNTAX, 2, 6, "a control character"},
    {"delete character", T("lensflare 1\nname a\177\n"),
     LFLARE_ERROR_SYNTAX, 2, 7, "a control character"},
    {"form feed", T("lensflare 1\n\f50 3\n"),
     LFLARE_ERROR_SYNTAX, 2, 1, "a control character"},
    {"no surfaces", T("lensflare 1\nname x\nfnumber 4\n"),
     LFLARE_ERROR_SYNTAX, 4, 1, "there are no surfaces"},
    {"no surfaces, no final newline", T("lensflare 1\nname x"),
     LFLARE_ERROR_SYNTAX, 2, 7, "there are no surfaces"},
    {"NaN radius", T("lensflare 1\nfnumber 4\nnan 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "unknown word 'nan' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')"},
    {"infinite radius", T("lensflare 1\nfnumber 4\ninf 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "unknown word 'inf' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')"},
    {"radius 1e400", T("lensflare 1\nfnumber 4\n1e400 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "the number '1e400' is too large"},
    {"radius 0", T("lensflare 1\nfnumber 4\n0 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "a radius is between 0.001 and 1e9 mm in size ('flat' for a plane), not '0'"},
    {"tiny radius", T("lensflare 1\nfnumber 4\n1e-9 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "a radius is between 0.001 and 1e9 mm in size ('flat' for a plane), not '1e-9'"},
    {"decimal comma", T("lensflare 1\nfnumber 4\n50,5 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "unknown word '50,5' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')"},
    {"hexadecimal", T("lensflare 1\nfnumber 4\n0x10 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "unknown word '0x10' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')"},
    {"exponent without digits", T("lensflare 1\nfnumber 4\n1e 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "unknown word '1e' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')"},
    {"two signs", T("lensflare 1\nfnumber 4\n--1 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "unknown word '--1' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')"},
    {"two points", T("lensflare 1\nfnumber 4\n1.2.3 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "unknown word '1.2.3' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')"},
    {"sign alone", T("lensflare 1\nfnumber 4\n- 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "unknown word '-' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')"},
    {"point alone", T("lensflare 1\nfnumber 4\n. 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "unknown word '.' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')"},
    {"unit glued on", T("lensflare 1\nfnumber 4\n50mm 3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "unknown word '50mm' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')"},
    {"unknown statement", T("lensflare 1\naperture 4\n50 3\n"),
     LFLARE_ERROR_SYNTAX, 2, 1, "unknown word 'aperture' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')"},
    {"unknown option", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coated\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 12, "unknown word 'coated' (options are air, n, nd, sellmeier, cauchy, glass, semi, conic, asphere and coating)"},
    {"capital option", T("lensflare 1\nfnumber 4\n50 3 N 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 6, "unknown word 'N' (options are air, n, nd, sellmeier, cauchy, glass, semi, conic, asphere and coating)"},
    {"long unknown word", T("lensflare 1\nfnumber 4\n50 3 abcdefghijklmnopqrstuvwxyz0123456789\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 6, "unknown word 'abcdefghijklmnopqrstuvwx...' (options are air, n, nd, sellmeier, cauchy, glass, semi, conic, asphere and coating)"},
    {"unprintable unknown word", T("lensflare 1\nfnumber 4\n50 3 \xc3\xa9\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 6, "unknown word '\?\?' (options are air, n, nd, sellmeier, cauchy, glass, semi, conic, asphere and coating)"},
    {"gap missing", T("lensflare 1\nfnumber 4\n50\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 3, "the gap to the next row is missing"},
    {"gap missing before a comment", T("lensflare 1\nfnumber 4\n50   # gap?\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 6, "the gap to the next row is missing"},
    {"gap is a word", T("lensflare 1\nfnumber 4\n50 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 4, "a number was expected, not 'n'"},
    {"gap negative", T("lensflare 1\nfnumber 4\n50 -3 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 4, "a gap is between 0 and 1e6 mm, not '-3'"},
    {"gap NaN", T("lensflare 1\nfnumber 4\n50 NaN n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 4, "a number was expected, not 'NaN'"},
    {"gap with a comma", T("lensflare 1\nfnumber 4\n50 1,5 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 4, "a number was expected, not '1,5'"},
    {"gap 1e400", T("lensflare 1\nfnumber 4\n50 1e400\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 4, "the number '1e400' is too large"},
    {"gap too large", T("lensflare 1\nfnumber 4\n50 1e7\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 4, "a gap is between 0 and 1e6 mm, not '1e7'"},
    {"focus in the middle", T("lensflare 1\nfnumber 4\n50 focus n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 4, 1, "a row follows the one whose gap is 'focus', which only the last can have"},
    {"stop in a middle focus", T("lensflare 1\n50 3 n 1.5\n-50 1\nstop focus\n30 2\n"),
     LFLARE_ERROR_SYNTAX, 5, 1, "a row follows the one whose gap is 'focus', which only the last can have"},
    {"stop without a gap", T("lensflare 1\n50 3 n 1.5\n-50 1\nstop\n"),
     LFLARE_ERROR_SYNTAX, 4, 5, "the gap to the next row is missing"},
    {"stop with a medium", T("lensflare 1\nfnumber 4\n50 3 n 1.5\nstop 2 n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 4, 8, "a stop has a gap and 'semi' only, not 'n'"},
    {"stop with air", T("lensflare 1\nfnumber 4\n50 3 n 1.5\nstop 2 air\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 4, 8, "a stop has a gap and 'semi' only, not 'air'"},
    {"stop with a coating", T("lensflare 1\nfnumber 4\n50 3 n 1.5\nstop 2 semi 5 coating none\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 4, 15, "a stop has a gap and 'semi' only, not 'coating'"},
    {"index below 1", T("lensflare 1\nfnumber 4\n50 3 n 0.9\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 8, "an index of refraction is between 1 and 5, not '0.9'"},
    {"index above 5", T("lensflare 1\nfnumber 4\n50 3 n 15\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 8, "an index of refraction is between 1 and 5, not '15'"},
    {"index missing", T("lensflare 1\nfnumber 4\n50 3 n\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 7, "a number is missing after 'n'"},
    {"index missing before an option", T("lensflare 1\nfnumber 4\n50 3 n semi 5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 8, "a number was expected, not 'semi'"},
    {"index NaN", T("lensflare 1\nfnumber 4\n50 3 n nan\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 8, "a number was expected, not 'nan'"},
    {"nd without vd", T("lensflare 1\nfnumber 4\n50 3 nd 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 12, "'vd' and the Abbe number must follow nd (or write 'n' for an index without dispersion)"},
    {"nd followed by another option", T("lensflare 1\nfnumber 4\n50 3 nd 1.5 semi 12\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 13, "'vd' and the Abbe number must follow nd (or write 'n' for an index without dispersion)"},
    {"nd, vd without a number", T("lensflare 1\nfnumber 4\n50 3 nd 1.5 vd\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 15, "a number is missing after 'vd'"},
    {"vd 0", T("lensflare 1\nfnumber 4\n50 3 nd 1.5 vd 0\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 16, "an Abbe number is between 5 and 200, not '0'"},
    {"vd alone", T("lensflare 1\nfnumber 4\n50 3 vd 60\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 6, "unknown word 'vd' (options are air, n, nd, sellmeier, cauchy, glass, semi, conic, asphere and coating)"},
    {"two media", T("lensflare 1\nfnumber 4\n50 3 n 1.5 nd 1.5 vd 60\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 12, "'nd' repeats or contradicts what this row already says"},
    {"air and glass", T("lensflare 1\nfnumber 4\n50 3 air n 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 10, "'n' repeats or contradicts what this row already says"},
    {"sellmeier with 5 numbers", T("lensflare 1\nfnumber 4\n50 3 sellmeier 1.03 0.23 1.01 0.006 0.02\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 41, "'sellmeier' takes six numbers, B1 B2 B3 C1 C2 C3"},
    {"sellmeier with 5 and an option", T("lensflare 1\nfnumber 4\n50 3 sellmeier 1.03 0.23 1.01 0.006 0.02 semi 5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 42, "a number was expected, not 'semi'"},
    {"sellmeier with 7", T("lensflare 1\nfnumber 4\n50 3 sellmeier 1.03 0.23 1.01 0.006 0.02 103 4\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 46, "unknown word '4' (options are air, n, nd, sellmeier, cauchy, glass, semi, conic, asphere and coating)"},
    {"cauchy with 1", T("lensflare 1\nfnumber 4\n50 3 cauchy 1.5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 16, "'cauchy' takes two or three numbers, A B C"},
    {"glass without a name", T("lensflare 1\nfnumber 4\n50 3 n 1.5 glass\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 17, "a name is missing after 'glass'"},
    {"glass name too long", T("lensflare 1\nfnumber 4\n50 3 n 1.5 glass ABCDEFGHIJKLMNOPQRSTUVWX\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 18, "the glass name 'ABCDEFGHIJKLMNOPQRSTUVWX' is longer than 23 bytes"},
    {"glass twice", T("lensflare 1\nfnumber 4\n50 3 n 1.5 glass A glass B\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 20, "'glass' repeats or contradicts what this row already says"},
    {"semi missing", T("lensflare 1\nfnumber 4\n50 3 n 1.5 semi\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 16, "a number is missing after 'semi'"},
    {"semi 0", T("lensflare 1\nfnumber 4\n50 3 n 1.5 semi 0\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 17, "a semi-diameter is between 0.0001 and 1e5 mm, not '0'"},
    {"semi negative", T("lensflare 1\nfnumber 4\n50 3 n 1.5 semi -4\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 17, "a semi-diameter is between 0.0001 and 1e5 mm, not '-4'"},
    {"semi twice", T("lensflare 1\nfnumber 4\n50 3 n 1.5 semi 5 semi 6\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 19, "'semi' repeats or contradicts what this row already says"},
    {"conic missing", T("lensflare 1\nfnumber 4\n50 3 n 1.5 conic\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 17, "a number is missing after 'conic'"},
    {"conic twice", T("lensflare 1\nfnumber 4\n50 3 n 1.5 conic 1 conic 1\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 20, "'conic' repeats or contradicts what this row already says"},
    {"conic too large", T("lensflare 1\nfnumber 4\n50 3 n 1.5 conic 1e7\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 18, "a conic constant is between -1e6 and 1e6, not '1e7'"},
    {"asphere without terms", T("lensflare 1\nfnumber 4\n50 3 n 1.5 asphere\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 19, "a term such as 4:1.5e-6 is missing after 'asphere'"},
    {"asphere with a plain number", T("lensflare 1\nfnumber 4\n50 3 n 1.5 asphere 1e-6\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 20, "a term such as 4:1.5e-6 was expected, not '1e-6'"},
    {"asphere with an odd power", T("lensflare 1\nfnumber 4\n50 3 n 1.5 asphere 3:1e-6\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 20, "the power of an aspheric term is even, 2 to 16, not as in '3:1e-6'"},
    {"asphere of power 18", T("lensflare 1\nfnumber 4\n50 3 n 1.5 asphere 4:1e-6 18:1e-9\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 27, "the power of an aspheric term is even, 2 to 16, not as in '18:1e-9'"},
    {"asphere of power 0", T("lensflare 1\nfnumber 4\n50 3 n 1.5 asphere 0:1\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 20, "the power of an aspheric term is even, 2 to 16, not as in '0:1'"},
    {"asphere of power 2.5", T("lensflare 1\nfnumber 4\n50 3 n 1.5 asphere 2.5:1\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 20, "the power of an aspheric term is even, 2 to 16, not as in '2.5:1'"},
    {"asphere repeats a power", T("lensflare 1\nfnumber 4\n50 3 n 1.5 asphere 4:1e-6 4:2e-6\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 27, "the power of '4:2e-6' is given twice"},
    {"asphere repeats a power after 0", T("lensflare 1\nfnumber 4\n50 3 n 1.5 asphere 4:0 4:2e-6\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 24, "the power of '4:2e-6' is given twice"},
    {"asphere power without a value", T("lensflare 1\nfnumber 4\n50 3 n 1.5 asphere 4:\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 22, "a number is missing here"},
    {"asphere value without a power", T("lensflare 1\nfnumber 4\n50 3 n 1.5 asphere :1e-6\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 20, "a number is missing here"},
    {"asphere with a blank", T("lensflare 1\nfnumber 4\n50 3 n 1.5 asphere 4: 1e-6\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 22, "a number is missing here"},
    {"coating missing", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coating\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 19, "'none', 'quarter NM' or 'stack N:NM ...' is missing after 'coating'"},
    {"coating unknown", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coating multi\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 20, "'none', 'quarter NM' or 'stack N:NM ...' was expected, not 'multi'"},
    {"quarter without a wavelength", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coating quarter\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 27, "a number is missing after 'quarter'"},
    {"quarter in micrometres", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coating quarter 0.55\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 28, "a wavelength is between 100 and 20000 nm, not '0.55'"},
    {"stack without layers", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coating stack\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 25, "a layer such as 1.38:99.6 is missing after 'stack'"},
    {"stack with a word", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coating stack MgF2\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 26, "a layer such as 1.38:99.6 was expected, not 'MgF2'"},
    {"layer below 1", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coating stack 0.5:99\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 26, "a layer's index is between 1 and 10, not '0.5'"},
    {"layer without thickness", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coating stack 1.38:\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 31, "a number is missing here"},
    {"layer of thickness 0", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coating stack 1.38:99 2.1:0\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 38, "a layer is between 0.01 and 100000 nm thick, not '0'"},
    {"layer NaN", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coating stack 1.38:nan\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 31, "a number was expected, not 'nan'"},
    {"layer of three numbers", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coating stack 1.38:99:2\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 31, "a number was expected, not '99:2'"},
    {"coating twice", T("lensflare 1\nfnumber 4\n50 3 n 1.5 coating none coating quarter 500\n-50 1\nstop focus\n"),
     LFLARE_ERROR_SYNTAX, 3, 25, "'coating' repeats or contradicts what this row already says"},
    {"fnumber missing", T("lensflare 1\nfnumber\n"),
     LFLARE_ERROR_SYNTAX, 2, 8, "a number is missing after 'fnumber'"},
    {"fnumber 0", T("lensflare 1\nfnumber 0\n"),
     LFLARE_ERROR_SYNTAX, 2, 9, "an f-number is between 0.1 and 1000, not '0'"},
    {"fnumber written f/4", T("lensflare 1\nfnumber f/4\n"),
     LFLARE_ERROR_SYNTAX, 2, 9, "a number was expected, not 'f/4'"},
    {"fnumber twice", T("lensflare 1\nfnumber 4\nfnumber 4\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "'fnumber' is given twice"},
    {"fnumber with two numbers", T("lensflare 1\nfnumber 4 5\n"),
     LFLARE_ERROR_SYNTAX, 2, 11, "'5' is one word too many"},
    {"sensor with one number", T("lensflare 1\nsensor 36\n"),
     LFLARE_ERROR_SYNTAX, 2, 10, "a number is missing after 'sensor'"},
    {"sensor negative", T("lensflare 1\nsensor 36 -24\n"),
     LFLARE_ERROR_SYNTAX, 2, 11, "a sensor's side is between 0.01 and 10000 mm, not '-24'"},
    {"sensor twice", T("lensflare 1\nsensor 36 24\nsensor 36 24\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "'sensor' is given twice"},
    {"sensor written 36x24", T("lensflare 1\nsensor 36x24\n"),
     LFLARE_ERROR_SYNTAX, 2, 8, "a number was expected, not '36x24'"},
    {"name empty", T("lensflare 1\nname   \n"),
     LFLARE_ERROR_SYNTAX, 2, 8, "a text is missing here"},
    {"name twice", T("lensflare 1\nname a\nname b\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "'name' is given twice"},
    {"name at the end", T("lensflare 1\nname"),
     LFLARE_ERROR_SYNTAX, 2, 5, "a text is missing here"},
    {"patent twice", T("lensflare 1\npatent a\npatent b\n"),
     LFLARE_ERROR_SYNTAX, 3, 1, "'patent' is given twice"},
    {"tabs count as one column", T("lensflare 1\n\t50\t3\tn\tx\n"),
     LFLARE_ERROR_SYNTAX, 2, 9, "a number was expected, not 'x'"},
    {"CR LF lines", T("lensflare 1\r\nfnumber 4\r\n50 3 x\r\n"),
     LFLARE_ERROR_SYNTAX, 3, 6, "unknown word 'x' (options are air, n, nd, sellmeier, cauchy, glass, semi, conic, asphere and coating)"},
    {"CR lines", T("lensflare 1\rfnumber 4\r50 3 x\r"),
     LFLARE_ERROR_SYNTAX, 3, 6, "unknown word 'x' (options are air, n, nd, sellmeier, cauchy, glass, semi, conic, asphere and coating)"},
    {"mixed line ends", T("lensflare 1\r\n\r\r\n\n50 3 x"),
     LFLARE_ERROR_SYNTAX, 5, 6, "unknown word 'x' (options are air, n, nd, sellmeier, cauchy, glass, semi, conic, asphere and coating)"},
    {"no final newline", T("lensflare 1\n50 3 n 0.5"),
     LFLARE_ERROR_SYNTAX, 2, 8, "an index of refraction is between 1 and 5, not '0.5'"},
    {"no stop", T("lensflare 1\nfnumber 4\n50 3 n 1.5\n-50 48\n"),
     LFLARE_ERROR_LENS, 4, 1, "there is no stop: add a row 'stop GAP' where the iris is"},
    {"no stop, last row has a comment", T("lensflare 1\n50 3 n 1.5 semi 5 # a\n-50 48 # b\n# c\n"),
     LFLARE_ERROR_LENS, 3, 1, "there is no stop: add a row 'stop GAP' where the iris is"},
    {"two stops", T("lensflare 1\nfnumber 4\nstop 1\n50 3 n 1.5\n-50 1\n  stop 48\n"),
     LFLARE_ERROR_LENS, 6, 1, "a second stop (the first is row 1); a lens has one"},
    {"only a stop", T("lensflare 1\nfnumber 4\nstop 50\n"),
     LFLARE_ERROR_LENS, 3, 1, "the lens has no focal length: parallel light leaves it parallel"},
    {"no focal length: planes", T("lensflare 1\nfnumber 4\nflat 3 n 1.5\nflat 1\nstop 30\n"),
     LFLARE_ERROR_LENS, 5, 1, "the lens has no focal length: parallel light leaves it parallel"},
    {"negative focal length", T("lensflare 1\nfnumber 4\n-50 3 n 1.5\n50 1\nstop 30\n"),
     LFLARE_ERROR_LENS, 5, 1, "the focal length is negative, -49.505 mm: the lens forms no real image"},
    {"ends in glass", T("lensflare 1\nfnumber 4\nstop 1\n50 30 n 1.5\n"),
     LFLARE_ERROR_LENS, 4, 1, "the lens ends in glass: the medium behind its last surface must be air"},
    {"ends in glass before the stop", T("lensflare 1\nfnumber 4\n50 3 n 1.5\nstop 30\n"),
     LFLARE_ERROR_LENS, 3, 1, "the lens ends in glass: the medium behind its last surface must be air"},
    {"focus inside the lens", T("lensflare 1\nfnumber 4\n10 80 n 1.9\nflat 1\nstop focus\n"),
     LFLARE_ERROR_LENS, 5, 1, "'focus' would put the sensor 31.9942 mm inside the lens"},
    {"stop in a focus", T("lensflare 1\nfnumber 4\n50 0 n 1.5\nflat 100\nstop 50\n50 0 n 1.5\nflat 80\n"),
     LFLARE_ERROR_LENS, 5, 1, "the stop stands in a focus, where it cannot limit the aperture"},
    {"aperture unknown", T("lensflare 1\n50 3 n 1.5\n-50 1\nstop 48\n"),
     LFLARE_ERROR_LENS, 4, 1, "the aperture is unknown: give 'fnumber', or 'semi' in the stop's row"},
    {"sellmeier out of range in between", T("lensflare 1\nfnumber 4\n50 3 sellmeier 9 9 9 0.1 0.1 0.1\n-50 1\nstop focus\n"),
     LFLARE_ERROR_LENS, 3, 1, "row 1: the medium's index of refraction leaves 1 to 5 between 380 and 650 nm"},
    {"sellmeier in nm^2", T("lensflare 1\nfnumber 4\n50 3 sellmeier 1.03961212 0.231792344 1.01046945 6000.69867 20017.9144 103560653\n-50 1\nstop focus\n"),
     LFLARE_ERROR_LENS, 3, 1, "row 1: the medium's index of refraction leaves 1 to 5 between 380 and 650 nm"},
    {"cauchy index below 1", T("lensflare 1\nfnumber 4\n50 3 cauchy 0.5 0.004\n-50 1\nstop focus\n"),
     LFLARE_ERROR_LENS, 3, 1, "row 1: the medium's index of refraction leaves 1 to 5 between 380 and 650 nm"},
    {"abbe index beyond 5", T("lensflare 1\nfnumber 4\n50 3 nd 5 vd 5\n-50 1\nstop focus\n"),
     LFLARE_ERROR_LENS, 3, 1, "row 1: the medium's index of refraction leaves 1 to 5 between 380 and 650 nm"},
};

/* Reads from a block of exactly this size, so that a sanitiser sees a byte too far. */
static lflare_result read_exact(const char *text, size_t size, lflare_prescription *p, lflare_error *error)
{
    lflare_result result;
    char *exact = (char *)malloc(size > 0 ? size : 1);
    assert_non_null(exact);
    if (size > 0) memcpy(exact, text, size);
    result = lflare_text_read(exact, size, p, error);
    free(exact);
    return result;
}

static lflare_result read_and_derive(const char *text, size_t size, lflare_lens *lens, lflare_error *error)
{
    static lflare_prescription p;
    lflare_result result = read_exact(text, size, &p, error);
    return result == LFLARE_OK ? lflare_lens_derive(&p, lens, error) : result;
}

static void expect_error(const broken *b)
{
    static lflare_lens lens;
    lflare_error error;
    lflare_result result;
    memset(&error, 'x', sizeof error);
    result = read_and_derive(b->text, b->size, &lens, &error);
    if (result != b->code || error.code != b->code || error.line != b->line || error.column != b->column || strcmp(error.text, b->message) != 0)
        fail_msg("%s: expected %d, %d:%d \"%s\", got %d, %d:%d \"%s\"", b->title, (int)b->code, (int)b->line, (int)b->column, b->message,
                 (int)result, (int)error.line, (int)error.column, error.text);
    assert_int_equal(read_and_derive(b->text, b->size, &lens, NULL), b->code); /* nobody need ask why */
}

static void test_broken(void **state)
{
    size_t i;
    (void)state;
    for (i = 0; i < sizeof broken_texts / sizeof *broken_texts; i++) expect_error(&broken_texts[i]);
}

/* Every prefix of a text, and every text with one byte missing or replaced: an answer, and a place within the text. */
static void test_cut_anywhere(void **state)
{
    static const char text[] = "lensflare 1\nname a # b\nfnumber 2.8\nsensor 36 24\n"
                               "50 3 nd 1.6 vd 60 glass X semi 12 conic -1.2 asphere 4:1.5e-6 6:-2e-9 coating stack 1.45:90 2.1:50.5\n"
                               "-80 1 coating quarter 520\nstop 3 semi 8 # iris\nflat 2 sellmeier 1 0.2 1 0.006 0.02 103\n-45 focus cauchy 1 0 0\n";
    static lflare_prescription p;
    char changed[sizeof text];
    lflare_error error;
    size_t n, k;
    static const char others[] = {0, '\n', ' ', '#', '-', ':', 'e', '9', (char)0xff};
    (void)state;
    for (n = 0; n < sizeof text; n++) {
        lflare_result result = read_exact(text, n, &p, &error);
        assert_int_equal(error.code, result);
        if (result != LFLARE_OK) assert_in_range(error.line, 1, 10);
    }
    for (n = 0; n + 1 < sizeof text; n++)
        for (k = 0; k < sizeof others; k++) {
            memcpy(changed, text, sizeof text);
            changed[n] = others[k];
            if (read_exact(changed, sizeof text - 1, &p, &error) != LFLARE_OK) {
                assert_in_range(error.line, 1, 11);
                assert_in_range(error.column, 1, 200);
                assert_true(strlen(error.text) > 5 && strlen(error.text) < sizeof error.text);
            }
        }
}

/* A text built by repetition. */
typedef struct builder {
    char *text;
    size_t size, room;
} builder;

static void add(builder *b, const char *piece, size_t times)
{
    size_t n = strlen(piece);
    if (b->size + n * times > b->room) {
        b->room = 2 * (b->size + n * times);
        b->text = (char *)realloc(b->text, b->room);
        assert_non_null(b->text);
    }
    for (; times > 0; times--, b->size += n) memcpy(b->text + b->size, piece, n);
}

static void expect_built(builder *b, lflare_result code, int32_t line, int32_t column, const char *message)
{
    broken expected;
    expected.title = message;
    expected.text = b->text;
    expected.size = b->size;
    expected.code = code;
    expected.line = line;
    expected.column = column;
    expected.message = message;
    expect_error(&expected);
    b->size = 0;
}

static void test_limits(void **state)
{
    builder b = {NULL, 0, 0};
    static lflare_lens lens;
    (void)state;
    add(&b, "lensflare 1\n", 1);
    add(&b, "50 3 n 1.5\n", 10000);
    expect_built(&b, LFLARE_ERROR_SYNTAX, 130, 1, "more than 128 rows");
    add(&b, "lensflare 1\nfnumber 8\nstop 1\n", 1);
    add(&b, "flat 0.1\n", 125);
    add(&b, "50 3 n 1.5\n-50 48\n", 1);
    assert_int_equal(read_and_derive(b.text, b.size, &lens, NULL), LFLARE_OK);
    assert_int_equal(lens.surface_count, 128);
    add(&b, "  flat 48\n", 1);
    expect_built(&b, LFLARE_ERROR_SYNTAX, 131, 3, "more than 128 rows");
    add(&b, "lensflare 1\nfnumber 8\n50 3 n 1.5 coating stack", 1);
    add(&b, " 1.5:90", 1000);
    add(&b, "\n-50 48 coating stack", 1);
    add(&b, " 1.5:90", 24);
    add(&b, "\nstop 3", 1);
    assert_int_equal(read_and_derive(b.text, b.size, &lens, NULL), LFLARE_OK);
    assert_int_equal(lens.prescription.layer_count, 1024);
    b.size -= 7;
    add(&b, " 1.5:90\n", 1);
    expect_built(&b, LFLARE_ERROR_SYNTAX, 4, 190, "more than 1024 coating layers");
    add(&b, "lensflare 1\nname ", 1);
    add(&b, "a", 95);
    add(&b, "   \npatent \t", 1);
    add(&b, "b", 95);
    add(&b, "\nsource ", 1);
    add(&b, "c", 255);
    add(&b, "\nfnumber 4\n50 3 n 1.5\n-50 1\nstop focus", 1);
    assert_int_equal(read_and_derive(b.text, b.size, &lens, NULL), LFLARE_OK);
    assert_true(strlen(lens.prescription.name) == 95 && strlen(lens.prescription.patent) == 95 && strlen(lens.prescription.source) == 255);
    b.size = 0;
    add(&b, "lensflare 1\nname ", 1);
    add(&b, "a", 96);
    expect_built(&b, LFLARE_ERROR_SYNTAX, 2, 101, "the text is too long from here on");
    add(&b, "lensflare 1\npatent ", 1);
    add(&b, "a", 5000);
    expect_built(&b, LFLARE_ERROR_SYNTAX, 2, 103, "the text is too long from here on");
    add(&b, "lensflare 1\nsource ", 1);
    add(&b, "a", 256);
    expect_built(&b, LFLARE_ERROR_SYNTAX, 2, 263, "the text is too long from here on");
    add(&b, "lensflare 1\n", 1);
    add(&b, " ", 200000);
    add(&b, "x", 1);
    add(&b, "y", 100000);
    expect_built(&b, LFLARE_ERROR_SYNTAX, 2, 200001,
                 "unknown word 'xyyyyyyyyyyyyyyyyyyyyyyy...' (a line begins with a radius, 'flat', 'stop', 'name', 'patent', 'source', 'fnumber' or 'sensor')");
    add(&b, "lensflare 1\n", 1);
    add(&b, "\n", 100000);
    add(&b, "50 ", 1);
    add(&b, "1", 1000);
    expect_built(&b, LFLARE_ERROR_SYNTAX, 100002, 4, "the number '111111111111111111111111...' is too large");
    free(b.text);
}

/* ---- texts that look odd and are right ---- */

static void test_accepted(void **state)
{
    static const struct {
        const char *text;
        size_t size;
    } good[] = {
        {T("lensflare 1\nfnumber 4\n50 3 n 1.5\n-50 1\nstop focus")},                      /* no final newline */
        {T("\xef\xbb\xbflensflare 1\nfnumber 4\n50 3 n 1.5\n-50 1\nstop focus\n")},         /* byte order mark */
        {T("lensflare 1\r\nfnumber 4\r\n50 3 n 1.5\r\n-50 1\r\nstop focus\r\n")},
        {T("lensflare 1\rfnumber 4\r50 3 n 1.5\r-50 1\rstop focus\r")},
        {T("\n# comment\n  lensflare\t1#\n\tfnumber  4 # four\n50\t3\tn\t1.5#x\n-50 1#\n stop focus #\n#")},
        {T("lensflare 1\n50 3 n 1.5\n-50 1\nstop focus\nfnumber 4\n")},                    /* statements in any order */
        {T("lensflare 1\nfnumber +4\n+50 3. n 1.5E+0\n-5.0e1 .1e1\nstop focus\n")},         /* ways to write numbers */
        {T("lensflare 1\nfnumber 0004\n00050.000 3 n 15e-1\n-500000000000000000000000000e-25 1\nstop focus\n")},
        {T("lensflare 1\nfnumber 4\n50 3 semi 30 conic 0 coating none glass x n 1.5\n-50 1 air glass y\nstop focus\n")}, /* options too */
        {T("lensflare 1\nfnumber 4\n50 3 n 1.5 asphere 4:0 6:0\n-50 1 asphere 16:1e-300\nstop focus\n")},
        {T("lensflare 1\nfnumber 4\n50 3 cauchy 1.5 0\n-50 1 cauchy 1 0 0 air\nstop focus\n") /* placeholder for its size */},
    };
    static lflare_lens lens;
    lflare_error error;
    size_t i;
    (void)state;
    for (i = 0; i + 1 < sizeof good / sizeof *good; i++) {
        if (read_and_derive(good[i].text, good[i].size, &lens, &error) != LFLARE_OK)
            fail_msg("text %d: %d:%d %s", (int)i, (int)error.line, (int)error.column, error.text);
        assert_true(error.code == LFLARE_OK && error.line == 0 && error.column == 0 && error.text[0] == 0);
        assert_int_equal(lens.surface_count, 3);
        assert_true(lens.prescription.surfaces[0].radius == 50 && lens.prescription.surfaces[0].thickness == 3 &&
                    lens.prescription.surfaces[0].medium.c[0] == 1.5 && lens.prescription.surfaces[1].radius == -50 &&
                    lens.prescription.surfaces[1].thickness == 1 && lens.prescription.fnumber == 4 && lens.prescription.focus == 1);
    }
    assert_int_equal(read_and_derive(good[i].text, good[i].size, &lens, &error), LFLARE_ERROR_SYNTAX); /* two media, even so */
}

static void test_values(void **state)
{
    static const char text[] = "lensflare 1\nname  Lens # 1, \xc3\xa9 \t\npatent US 1 # 2\nsource  here\nfnumber 2.8\nsensor 23.6 15.8\n"
                               "50 3 nd 1.6 vd 60.5 glass N-X# y\n"
                               "-80 1.5 semi 12.25 conic -1.5 asphere 2:1e-5 16:-3e-20 4:7e-7 coating quarter 520\n"
                               "stop 3 semi 8\n"
                               "flat 2 sellmeier 1.03961212 0.231792344 1.01046945 0.00600069867 0.0200179144 103.560653 coating stack 1.45:90 2.1:50.5\n"
                               "-45 1 cauchy 1.5 0.004 semi 9\n"
                               "-55 77 coating stack 1.38:99.6\n";
    static lflare_prescription p;
    const lflare_surface *s = p.surfaces;
    (void)state;
    assert_int_equal(read_exact(T(text), &p, NULL), LFLARE_OK);
    assert_string_equal(p.name, "Lens # 1, \xc3\xa9"); /* '#' belongs to a text; blanks at its ends do not */
    assert_string_equal(p.patent, "US 1 # 2");
    assert_string_equal(p.source, "here");
    assert_true(p.fnumber == 2.8 && p.sensor_width == 23.6 && p.sensor_height == 15.8 && p.focus == 0);
    assert_true(p.surface_count == 6 && p.layer_count == 3);
    assert_true(s[0].medium.kind == LFLARE_MEDIUM_ABBE && s[0].medium.c[0] == 1.6 && s[0].medium.c[1] == 60.5);
    assert_string_equal(s[0].medium.glass, "N-X"); /* here it begins a comment */
    assert_true(s[1].medium.kind == LFLARE_MEDIUM_AIR && s[1].semi_diameter == 12.25 && s[1].conic == -1.5);
    assert_true(s[1].aspheric[0] == 1e-5 && s[1].aspheric[1] == 7e-7 && s[1].aspheric[7] == -3e-20 && s[1].aspheric[2] == 0);
    assert_true(s[1].coating == LFLARE_COATING_QUARTER && s[1].quarter_nm == 520);
    assert_true(s[2].is_stop == 1 && s[2].radius == 0 && s[2].thickness == 3 && s[2].semi_diameter == 8 && s[2].line == 9);
    assert_true(s[3].radius == 0 && s[3].medium.kind == LFLARE_MEDIUM_SELLMEIER && s[3].medium.c[5] == 103.560653);
    assert_true(s[3].coating == LFLARE_COATING_STACK && s[3].first_layer == 0 && s[3].layer_count == 2);
    assert_true(p.layers[0].n == 1.45 && p.layers[0].thickness_nm == 90 && p.layers[1].n == 2.1 && p.layers[1].thickness_nm == 50.5);
    assert_true(s[4].medium.kind == LFLARE_MEDIUM_CAUCHY && s[4].medium.c[1] == 0.004 && s[4].medium.c[2] == 0 && s[4].semi_diameter == 9);
    assert_true(s[5].first_layer == 2 && s[5].layer_count == 1 && s[5].thickness == 77 && s[5].line == 12);
}

/* ---- round trips ---- */

static uint64_t chance_state = 1;

static uint64_t chance(void) /* splitmix64 */
{
    uint64_t z = (chance_state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}
static int32_t below(int32_t n) { return (int32_t)(chance() % (uint64_t)n); }
static double between(double lo, double hi) { return lo + (hi - lo) * ((double)(chance() >> 11) / 9007199254740992.0); }

/* Between two positive numbers, evenly over magnitudes; often short. */
static double magnitude(double lo, double hi)
{
    double v = exp(between(log(lo), log(hi)));
    if (below(2)) v = floor(v * 1000 + 0.5) / 1000;
    return v < lo ? lo : v > hi ? hi : v;
}

static void make_text(char *out, int32_t size)
{
    static const char letters[] = "abcXYZ 0123456789#:.,-_/()\xc3\xa9";
    int32_t n = below(4) ? below(20) : below(size), i;
    for (i = 0; i < n; i++) out[i] = letters[below((int32_t)sizeof letters - 1)];
    for (; n > 0 && out[n - 1] == ' '; n--) {}
    memset(out + n, 0, (size_t)(size - n));
    if (out[0] == ' ') out[0] = 'x';
}

static void make_medium(lflare_medium *m)
{
    int32_t i, n;
    m->kind = (lflare_medium_kind)below(5);
    if (m->kind == LFLARE_MEDIUM_CONSTANT || m->kind == LFLARE_MEDIUM_ABBE) m->c[0] = between(1, 5);
    if (m->kind == LFLARE_MEDIUM_ABBE) m->c[1] = between(5, 200);
    n = m->kind == LFLARE_MEDIUM_SELLMEIER ? 6 : m->kind == LFLARE_MEDIUM_CAUCHY ? 2 + below(2) : 0;
    for (i = 0; i < n; i++) m->c[i] = magnitude(1e-12, 1e12) * (below(2) ? 1 : -1);
    if (below(3) == 0)
        for (i = 0, n = 1 + below(23); i < n; i++) m->glass[i] = "ABCNSF-0123456789.:_"[below(20)];
}

/* Any prescription that can be written down; hardly ever a lens. */
static void make_prescription(lflare_prescription *p)
{
    int32_t i, k;
    memset(p, 0, sizeof *p);
    if (below(2)) make_text(p->name, (int32_t)sizeof p->name);
    if (below(3) == 0) make_text(p->patent, (int32_t)sizeof p->patent);
    if (below(3) == 0) make_text(p->source, (int32_t)sizeof p->source);
    if (below(2)) p->fnumber = magnitude(0.1, 1000);
    if (below(2)) {
        p->sensor_width = magnitude(0.01, 1e4);
        p->sensor_height = magnitude(0.01, 1e4);
    }
    p->surface_count = 1 + below(below(10) ? 20 : LFLARE_MAX_SURFACES);
    p->focus = below(2);
    for (i = 0; i < p->surface_count; i++) {
        lflare_surface *s = &p->surfaces[i];
        s->is_stop = below(8) == 0;
        if (i + 1 < p->surface_count || !p->focus) s->thickness = below(5) ? magnitude(1e-9, 1e6) : 0;
        if (below(2)) s->semi_diameter = magnitude(1e-4, 1e5);
        if (s->is_stop) continue;
        if (below(8)) s->radius = magnitude(1e-3, 1e9) * (below(2) ? 1 : -1);
        if (below(4) == 0) s->conic = magnitude(1e-9, 1e6) * (below(2) ? 1 : -1);
        if (below(4) == 0)
            for (k = 0; k < 8; k++)
                if (below(2)) s->aspheric[k] = magnitude(1e-290, 1e12) * (below(2) ? 1 : -1);
        make_medium(&s->medium);
        s->coating = (lflare_coating_kind)below(3);
        if (s->coating == LFLARE_COATING_QUARTER) s->quarter_nm = magnitude(100, 20000);
        if (s->coating == LFLARE_COATING_STACK) {
            s->first_layer = p->layer_count;
            s->layer_count = 1 + below(below(8) ? 5 : 60);
            if (s->layer_count > LFLARE_MAX_LAYERS - p->layer_count) s->layer_count = LFLARE_MAX_LAYERS - p->layer_count;
            if (s->layer_count == 0) s->coating = LFLARE_COATING_NONE;
            if (s->layer_count == 0) s->first_layer = 0;
            for (k = 0; k < s->layer_count; k++) {
                p->layers[p->layer_count].n = between(1, 10);
                p->layers[p->layer_count++].thickness_nm = magnitude(0.01, 1e5);
            }
        }
    }
}

static void forget_lines(lflare_prescription *p)
{
    int32_t i;
    for (i = 0; i < p->surface_count; i++) p->surfaces[i].line = 0;
}

static void expect_round_trip(const lflare_prescription *p)
{
    static lflare_prescription a, b;
    static char text[200000], again[200000];
    size_t size = sizeof text, size2 = sizeof again;
    lflare_error error;
    assert_int_equal(lflare_text_write(p, text, &size), LFLARE_OK);
    if (read_exact(text, size, &b, &error) != LFLARE_OK)
        fail_msg("what was written cannot be read: %d:%d %s\n%.*s", (int)error.line, (int)error.column, error.text, (int)size, text);
    a = *p;
    forget_lines(&a);
    forget_lines(&b);
    if (memcmp(&a, &b, sizeof a) != 0) fail_msg("not the same when read again:\n%.*s", (int)size, text);
    assert_int_equal(lflare_text_write(&b, again, &size2), LFLARE_OK);
    assert_true(size == size2);
    assert_memory_equal(text, again, size);
}

static void test_round_trip_random(void **state)
{
    static lflare_prescription p;
    int32_t i;
    (void)state;
    for (i = 0; i < 2000; i++) {
        make_prescription(&p);
        expect_round_trip(&p);
    }
}

/* The lenses shipped and the golden ones, each of which is a lens too. */
static void test_round_trip_files(void **state)
{
    static const char *const list = "build/test_text_files";
    static lflare_prescription p;
    static lflare_lens lens;
    lflare_error error;
    char path[256], *text;
    size_t size, at, end, files = 0;
    (void)state;
    assert_int_equal(system("mkdir -p build && ls tests/data/*.lens lenses/*.lens > build/test_text_files"), 0);
    {
        char *names;
        assert_int_equal(lflare_file_read(list, NULL, NULL, &names, &size, &error), LFLARE_OK);
        for (at = 0; at < size; at = end + 1, files++) {
            size_t length;
            for (end = at; names[end] != '\n'; end++) {}
            assert_true(end - at < sizeof path);
            memcpy(path, names + at, end - at);
            path[end - at] = 0;
            assert_int_equal(lflare_file_read(path, NULL, NULL, &text, &length, &error), LFLARE_OK);
            if (lflare_text_read(text, length, &p, &error) != LFLARE_OK) fail_msg("%s:%d:%d: %s", path, (int)error.line, (int)error.column, error.text);
            if (lflare_lens_derive(&p, &lens, &error) != LFLARE_OK) fail_msg("%s:%d:%d: %s", path, (int)error.line, (int)error.column, error.text);
            free(text);
            expect_round_trip(&p);
            if (p.focus) lens.prescription.surfaces[lens.surface_count - 1].thickness = 0; /* it is written as 'focus' */
            expect_round_trip(&lens.prescription);
        }
        free(names);
    }
    assert_true(files >= 2);
    remove(list);
}

static void test_writer_room(void **state)
{
    static lflare_prescription p;
    static char whole[200000], part[200000];
    size_t need = 0, size, room;
    int32_t i;
    (void)state;
    for (i = 0; i < 20; i++) {
        make_prescription(&p);
        need = 0;
        assert_int_equal(lflare_text_write(&p, NULL, &need), LFLARE_INCOMPLETE);
        size = need;
        assert_int_equal(lflare_text_write(&p, whole, &size), LFLARE_OK);
        assert_true(size == need);
        for (room = 0; room < need; room += 1 + need / 50) {
            memset(part, 0x5a, need + 1);
            size = room;
            assert_int_equal(lflare_text_write(&p, part, &size), LFLARE_INCOMPLETE);
            assert_true(size == need);
            assert_memory_equal(part, whole, room);
            for (size = room; size <= need; size++) assert_int_equal(part[size], 0x5a);
        }
        size = need - 1;
        assert_int_equal(lflare_text_write(&p, part, &size), LFLARE_INCOMPLETE);
    }
    assert_int_equal(lflare_text_write(NULL, part, &size), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_text_write(&p, part, NULL), LFLARE_ERROR_ARGUMENT);
    size = 1;
    assert_int_equal(lflare_text_write(&p, NULL, &size), LFLARE_ERROR_ARGUMENT);
}

/* Texts and labels that would break the lines or words they stand in; texts without a terminating zero; blanks only. */
static void test_writer_harmless(void **state)
{
    static lflare_prescription p, q;
    static char text[4096];
    size_t size = sizeof text;
    lflare_error error;
    (void)state;
    assert_int_equal(read_exact(T("lensflare 1\nfnumber 4\n50 3 n 1.5\n-50 1\nstop focus\n"), &p, NULL), LFLARE_OK);
    strcpy(p.name, "a\nstop 3\r\x01\x7f#b");
    memset(p.patent, 'p', sizeof p.patent);
    strcpy(p.source, "\t \n ");
    strcpy(p.surfaces[0].medium.glass, "N BK#7\n\x7f\tz\xc3\xa9");
    memset(p.surfaces[1].medium.glass, 'g', sizeof p.surfaces[1].medium.glass);
    assert_int_equal(lflare_text_write(&p, text, &size), LFLARE_OK);
    if (read_exact(text, size, &q, &error) != LFLARE_OK) fail_msg("%d:%d %s\n%.*s", (int)error.line, (int)error.column, error.text, (int)size, text);
    assert_string_equal(q.name, "a stop 3   #b");
    assert_true(strlen(q.patent) == 95 && strspn(q.patent, "p") == 95);
    assert_string_equal(q.source, "");
    assert_string_equal(q.surfaces[0].medium.glass, "N_BK_7___z\xc3\xa9");
    assert_true(strlen(q.surfaces[1].medium.glass) == 23);
    assert_int_equal(q.surface_count, 3);
    p.surfaces[0].coating = LFLARE_COATING_STACK; /* layers that lie nowhere */
    p.surfaces[0].layer_count = 5;
    p.surfaces[0].first_layer = 1020;
    assert_int_equal(lflare_text_write(&p, text, &size), LFLARE_ERROR_ARGUMENT);
    p.surfaces[0].first_layer = -1;
    assert_int_equal(lflare_text_write(&p, text, &size), LFLARE_ERROR_ARGUMENT);
    p.surfaces[0].first_layer = 0;
    p.surfaces[0].layer_count = INT32_MAX;
    assert_int_equal(lflare_text_write(&p, text, &size), LFLARE_ERROR_ARGUMENT);
    p.surface_count = -1;
    assert_int_equal(lflare_text_write(&p, text, &size), LFLARE_ERROR_ARGUMENT);
    p.surface_count = 129;
    assert_int_equal(lflare_text_write(&p, text, &size), LFLARE_ERROR_ARGUMENT);
}

/* ---- numbers ---- */

static void expect_number_round_trip(double v)
{
    char text[40] = {0};
    double back = 0;
    int32_t n;
    memset(text, '~', sizeof text);
    n = lflare_number_write(v, text);
    assert_true(n > 0 && n <= 32 && text[32] == '~' && text[n] == '~');
    if (!lflare_number_read(text, (size_t)n, &back) || back != v) fail_msg("%.17g is written %.*s and read as %.17g", v, (int)n, text, back);
}

static double random_double(void)
{
    double v;
    uint64_t bits;
    for (;;) {
        bits = chance();
        memcpy(&v, &bits, sizeof v);
        if (fabs(v) > 1e-300 && fabs(v) < 1e300) return v; /* false for what is no number */
    }
}

static double short_decimal(void)
{
    double scale = pow(10, below(10));
    return (double)((int64_t)(chance() % 2000000000u) - 1000000000) / scale;
}

static void round_trip_numbers(int32_t count)
{
    int32_t i;
    for (i = 0; i < count; i++) expect_number_round_trip(i % 2 ? random_double() : i % 4 ? short_decimal() : between(-100, 100));
}

static void test_number_round_trip(void **state)
{
    (void)state;
    round_trip_numbers(1000000);
    expect_number_round_trip(0);
    expect_number_round_trip(1.7976931348623157e308);
    expect_number_round_trip(2.2250738585072014e-308);
    expect_number_round_trip(4.9406564584124654e-324);
    expect_number_round_trip(-1.2345e-310);
    expect_number_round_trip(-126215.41552734375);
    expect_number_round_trip(9007199254740993.0);
    expect_number_round_trip(0.1 + 0.2);
}

/* Decimals of up to 19 digits, against libc's reader: equal to the last bit. */
static void compare_with_libc(int32_t count)
{
    int32_t i, k;
    for (i = 0; i < count; i++) {
        char text[64];
        double own = 0, libc;
        int32_t n = 0, digits = 1 + below(19), point = below(digits + 2);
        if (below(3) == 0) text[n++] = "+-"[below(2)];
        for (k = 0; k < digits; k++) {
            if (k == point) text[n++] = '.';
            text[n++] = (char)('0' + below(10));
        }
        if (below(2)) n += sprintf(text + n, "%c%d", "eE"[below(2)], (int)(below(2) ? below(560) - 290 : below(40) - 20));
        text[n] = 0;
        libc = strtod(text, NULL);
        if (!lflare_number_read(text, (size_t)n, &own)) fail_msg("%s is refused", text);
        if (own != libc) fail_msg("%s: libc reads %.17g, we %.17g, %g apart", text, libc, own, (own - libc) / libc);
    }
}

static void test_number_libc(void **state)
{
    (void)state;
    compare_with_libc(1000000);
}

static void test_number_forms(void **state)
{
    static const struct {
        const char *text;
        double value;
    } good[] = {{"0", 0},       {"+5", 5},        {"-5", -5},     {".5", 0.5},          {"5.", 5},     {"1.2E+1", 12},  {"1e3", 1000},
                {"1e-3", 1e-3}, {"007", 7},       {"1e0", 1},     {"0e999999999", 0},   {"-.5e1", -5}, {"1e99999999999999999999", HUGE_VAL},
                {"-1e400", -HUGE_VAL},            {"1e-99999999999999999999", 0},       {"123456789012345678901234567890", 123456789012345678901234567890.0},
                {"0.000000000000000000000000000001", 1e-30}, {"1.7976931348623157e308", 1.7976931348623157e308}, {"1e308", 1e308}, {"9.99e305", 9.99e305},
                {"2.2250738585072014e-308", 2.2250738585072014e-308}, {"179769313486231570000e289", HUGE_VAL}};
    static const char *const bad[] = {"",   "+",   "-",    ".",     "-.",   "e5",  "1e",   "1e+",  "1e-",   "--1",  "+-1", "1,5", "0x10", "1.2.3", "1e5.0", " 1",
                                      "1 ", "nan", "NaN",  "inf",   "Infinity", "1f", "1_000", "1'000", "\xef\xbc\x91", "1e5e5", "1d3"};
    size_t i;
    double v;
    char text[40];
    (void)state;
    for (i = 0; i < sizeof good / sizeof *good; i++) {
        v = -77;
        if (!lflare_number_read(good[i].text, strlen(good[i].text), &v) || v != good[i].value) fail_msg("%s is read as %.17g", good[i].text, v);
    }
    for (i = 0; i < sizeof bad / sizeof *bad; i++)
        if (lflare_number_read(bad[i], strlen(bad[i]), &v)) fail_msg("'%s' is accepted as %.17g", bad[i], v);
    assert_int_equal(lflare_number_read("12345", 2, &v), 1); /* no further than told */
    assert_true(v == 12);
    assert_int_equal(lflare_number_read("-0", 2, &v), 1);
    text[lflare_number_write(v, text)] = 0;
    assert_string_equal(text, "0");
    text[lflare_number_write(0.1, text)] = 0;
    assert_string_equal(text, "0.1");
    text[lflare_number_write(-1e-5, text)] = 0;
    assert_string_equal(text, "-0.00001");
    text[lflare_number_write(-1.5e-6, text)] = 0;
    assert_string_equal(text, "-1.5e-6");
    text[lflare_number_write(1e22, text)] = 0;
    assert_string_equal(text, "1e22");
    text[lflare_number_write(123456, text)] = 0;
    assert_string_equal(text, "123456");
    text[lflare_number_write(0.001234, text)] = 0;
    assert_string_equal(text, "0.001234");
    text[lflare_number_write(HUGE_VAL, text)] = 0;
    assert_string_equal(text, "inf");
    text[lflare_number_write(-HUGE_VAL, text)] = 0;
    assert_string_equal(text, "-inf");
    text[lflare_number_write(HUGE_VAL - HUGE_VAL, text)] = 0;
    assert_string_equal(text, "nan");
}

/* tests/run makes the locale where the system has none (LOCPATH). */
static void test_comma_locale(void **state)
{
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "de_DE", "fr_FR.UTF-8", "fr_FR.utf8", "nl_NL.UTF-8"};
    static lflare_prescription p;
    size_t i;
    (void)state;
    for (i = 0; i < sizeof names / sizeof *names && setlocale(LC_ALL, names[i]) == NULL; i++) {}
    if (i == sizeof names / sizeof *names || localeconv()->decimal_point[0] != ',') {
        print_message("no locale with a decimal comma is installed\n");
        setlocale(LC_ALL, "C");
        skip();
    }
    round_trip_numbers(1000);
    test_number_forms(NULL);
    test_broken(NULL);
    for (i = 0; i < 100; i++) {
        make_prescription(&p);
        expect_round_trip(&p);
    }
    setlocale(LC_ALL, "C");
}

/* ---- what is derived ---- */

static void expect_near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance)) fail_msg("expected %.17g, got %.17g", expected, value);
}

static const lflare_note *find_note(const lflare_lens *lens, lflare_note_kind kind, int32_t surface)
{
    int32_t i;
    for (i = 0; i < lens->note_count; i++)
        if (lens->notes[i].kind == kind && lens->notes[i].surface == surface) return &lens->notes[i];
    return NULL;
}

static void derive(const char *text, lflare_lens *lens)
{
    lflare_error error;
    if (read_and_derive(text, strlen(text), lens, &error) != LFLARE_OK) fail_msg("%d:%d %s", (int)error.line, (int)error.column, error.text);
}

static void expect_text(const lflare_note *note, const char *expected)
{
    char text[LFLARE_MAX_NOTES];
    assert_non_null(note);
    assert_string_equal(lflare_note_text(note, text, sizeof text), expected);
}

/* A thin lens of f = 100 (n = 1.5, R = 50 and flat... R = 50), all by hand: power (n - 1)/R = 0.01, no thickness. */
static void test_notes(void **state)
{
    static lflare_lens lens;
    const lflare_note *note;
    char text[8];
    (void)state;
    /* stop derived from the f-number, focus derived, sensor assumed, semi-diameters derived */
    derive("lensflare 1\nfnumber 4\n50 0 n 1.5\nflat 0\nstop focus\n", &lens);
    expect_near(lens.efl, 100, 1e-9);
    expect_near(lens.prescription.surfaces[2].thickness, 100, 1e-9);
    expect_near(lens.prescription.surfaces[2].semi_diameter, 12.5, 1e-9);
    expect_near(lens.fnumber, 4, 1e-9);
    assert_true(lens.sensor_width == 36 && lens.sensor_height == 24 && lens.ghost_count == 1 && lens.stop == 2);
    expect_text(find_note(&lens, LFLARE_NOTE_SENSOR_ASSUMED, -1), "no sensor is given: 36 x 24 mm assumed");
    expect_text(find_note(&lens, LFLARE_NOTE_FOCUS_DERIVED, 2), "row 3: the sensor is put in focus, 100 mm behind");
    expect_text(find_note(&lens, LFLARE_NOTE_STOP_DERIVED, 2), "row 3: the stop's semi-diameter 12.5 mm is derived");
    assert_non_null(find_note(&lens, LFLARE_NOTE_SEMI_DERIVED, 0));
    assert_non_null(find_note(&lens, LFLARE_NOTE_SEMI_DERIVED, 1));
    assert_null(find_note(&lens, LFLARE_NOTE_SEMI_DERIVED, 2));
    assert_null(find_note(&lens, LFLARE_NOTE_OUT_OF_FOCUS, 2));
    /* f-number derived from the stop; the sensor out of focus by more than half a percent */
    derive("lensflare 1\nsensor 36 24\n50 0 n 1.5 semi 20\nflat 0 semi 20\nstop 101 semi 10\n", &lens);
    expect_near(lens.fnumber, 5, 1e-9);
    expect_text(find_note(&lens, LFLARE_NOTE_FNUMBER_DERIVED, -1), "f-number 5 derived from the stop");
    expect_text(find_note(&lens, LFLARE_NOTE_OUT_OF_FOCUS, 2), "the sensor is 101 mm behind the last surface, the paraxial focus 100 mm");
    assert_non_null(find_note(&lens, LFLARE_NOTE_EDGES_CROSS, 0)); /* a bulge without thickness */
    assert_int_equal(lens.note_count, 3);
    derive("lensflare 1\nsensor 36 24\n50 0 n 1.5 semi 20\nflat 0 semi 20\nstop 100.4 semi 10\n", &lens);
    assert_null(find_note(&lens, LFLARE_NOTE_OUT_OF_FOCUS, 2));
    /* f-number faster than the stop allows */
    derive("lensflare 1\nfnumber 2\nsensor 36 24\n50 0 n 1.5 semi 20\nflat 0 semi 20\nstop 100 semi 10\n", &lens);
    expect_near(lens.fnumber, 5, 1e-9);
    expect_text(find_note(&lens, LFLARE_NOTE_FNUMBER_LIMITED, -1), "f/2 is stated, but the stop's semi-diameter allows f/5");
    /* stop from what the other rims pass */
    derive("lensflare 1\nsensor 36 24\n50 0 n 1.5 semi 8\nflat 0 semi 20\nstop 100\n", &lens);
    expect_near(lens.prescription.surfaces[2].semi_diameter, 8, 1e-9);
    assert_non_null(find_note(&lens, LFLARE_NOTE_STOP_DERIVED, 2));
    assert_non_null(find_note(&lens, LFLARE_NOTE_FNUMBER_DERIVED, -1));
    /* semi-diameter beyond the sphere's end */
    derive("lensflare 1\nfnumber 8\nsensor 36 24\n50 60 n 1.5 semi 55\nflat 0 semi 20\nstop 61\n", &lens);
    note = find_note(&lens, LFLARE_NOTE_SEMI_REDUCED, 0);
    assert_non_null(note);
    assert_true(note->stated == 55 && note->value <= 50 && note->value > 45 && note->value == lens.prescription.surfaces[0].semi_diameter);
    /* edges that cross: two spheres of 50 mm, 1 mm apart, 20 mm wide */
    derive("lensflare 1\nfnumber 8\nsensor 36 24\n50 1 n 1.5 semi 20\n-50 1 semi 20\nstop focus\n", &lens);
    note = find_note(&lens, LFLARE_NOTE_EDGES_CROSS, 0);
    assert_non_null(note);
    expect_near(note->value, 1 - 2 * (50 - sqrt(50.0 * 50 - 20.0 * 20)), 1e-9);
    expect_text(note, "rows 1 and 2 cross: -7.34849 mm thick at the edge");
    /* short buffers are terminated */
    memset(text, 'x', sizeof text);
    assert_string_equal(lflare_note_text(note, text, 4), "row");
    assert_string_equal(lflare_note_text(note, text, 1), "");
    text[0] = 'x';
    lflare_note_text(note, text, 0);
    assert_int_equal(text[0], 'x');
}

static void test_quarter_and_stack(void **state)
{
    static lflare_lens lens;
    lflare_layer layers[4];
    int32_t n;
    (void)state;
    derive("lensflare 1\nfnumber 8\n50 3 n 1.5 coating quarter 552\n-50 1 coating stack 1.38:99 2.1:60\n"
           "stop 1\n90 2 n 2.25 coating quarter 600\n-90 40 coating none\n", &lens);
    n = 4;
    assert_int_equal(lflare_film_layers(&lens, 0, layers, &n), LFLARE_OK);
    assert_true(n == 1 && layers[0].n == 1.38); /* sqrt(1.5) is less */
    expect_near(layers[0].thickness_nm, 100, 1e-9);
    n = 4;
    assert_int_equal(lflare_film_layers(&lens, 3, layers, &n), LFLARE_OK);
    expect_near(layers[0].n, 1.5, 1e-12);
    expect_near(layers[0].thickness_nm, 100, 1e-9);
    n = 1;
    assert_int_equal(lflare_film_layers(&lens, 1, layers, &n), LFLARE_INCOMPLETE);
    assert_int_equal(n, 2);
    assert_int_equal(lflare_film_layers(&lens, 1, layers, &n), LFLARE_OK);
    assert_true(layers[0].n == 1.38 && layers[1].thickness_nm == 60); /* from the front side */
    n = 4;
    assert_int_equal(lflare_film_layers(&lens, 2, layers, &n), LFLARE_OK);
    assert_int_equal(n, 0);
    n = 4;
    assert_int_equal(lflare_film_layers(&lens, 4, layers, &n), LFLARE_OK);
    assert_int_equal(n, 0);
    expect_near(lflare_film_reflectance(1, 1.9044, layers, 0, 552, 0), 0.9044 * 0.9044 / (2.9044 * 2.9044), 1e-12);
    layers[0].n = 1.38;
    layers[0].thickness_nm = 100;
    expect_near(lflare_film_reflectance(1, 1.9044, layers, 1, 552, 0), 0, 1e-12); /* a quarter wave of sqrt(n) reflects nothing */
}

/* ---- prescriptions made by hand ---- */

static void start(lflare_prescription *p)
{
    assert_int_equal(read_exact(T("lensflare 1\nfnumber 4\nsensor 36 24\n50 3 n 1.5\n-50 1\nstop focus\n"), p, NULL), LFLARE_OK);
    forget_lines(p);
}

static void expect_refused(const lflare_prescription *p, const char *message)
{
    static lflare_lens lens;
    lflare_error error;
    lflare_result result = lflare_lens_derive(p, &lens, &error);
    if (result != LFLARE_ERROR_LENS || error.code != result || error.line != 0 || error.column != 0 || strcmp(error.text, message) != 0)
        fail_msg("expected \"%s\", got %d, %d:%d \"%s\"", message, (int)result, (int)error.line, (int)error.column, error.text);
}

static void test_made_by_hand(void **state)
{
    static lflare_prescription p;
    static lflare_lens lens;
    const double nan = HUGE_VAL - HUGE_VAL;
    (void)state;
    memset(&p, 0, sizeof p);
    expect_refused(&p, "a lens has 1 to 128 rows, not 0");
    start(&p); p.surface_count = -5; expect_refused(&p, "a lens has 1 to 128 rows, not -5");
    start(&p); p.surface_count = 129; expect_refused(&p, "a lens has 1 to 128 rows, not 129");
    start(&p); p.surfaces[0].radius = nan; expect_refused(&p, "row 1: a radius is between 0.001 and 1e9 mm in size ('flat' for a plane)");
    start(&p); p.surfaces[0].radius = HUGE_VAL; expect_refused(&p, "row 1: a radius is between 0.001 and 1e9 mm in size ('flat' for a plane)");
    start(&p); p.surfaces[1].thickness = HUGE_VAL; expect_refused(&p, "row 2: a gap is between 0 and 1e6 mm");
    start(&p); p.surfaces[1].thickness = -1; expect_refused(&p, "row 2: a gap is between 0 and 1e6 mm");
    start(&p); p.surfaces[1].thickness = nan; expect_refused(&p, "row 2: a gap is between 0 and 1e6 mm");
    start(&p); p.surfaces[1].semi_diameter = -3; expect_refused(&p, "row 2: a semi-diameter is between 0.0001 and 1e5 mm");
    start(&p); p.surfaces[1].semi_diameter = nan; expect_refused(&p, "row 2: a semi-diameter is between 0.0001 and 1e5 mm");
    start(&p); p.surfaces[1].conic = nan; expect_refused(&p, "row 2: a conic constant is between -1e6 and 1e6");
    start(&p); p.surfaces[1].aspheric[7] = -HUGE_VAL; expect_refused(&p, "row 2: a coefficient is between -1e12 and 1e12");
    start(&p); p.surfaces[0].medium.c[0] = nan; expect_refused(&p, "row 1: the medium's index of refraction leaves 1 to 5 between 380 and 650 nm");
    start(&p); p.surfaces[0].medium.kind = LFLARE_MEDIUM_ABBE; p.surfaces[0].medium.c[1] = 0;
    expect_refused(&p, "row 1: the medium's index of refraction leaves 1 to 5 between 380 and 650 nm");
    start(&p); p.surfaces[0].coating = LFLARE_COATING_QUARTER; expect_refused(&p, "row 1: a wavelength is between 100 and 20000 nm");
    start(&p); p.surfaces[0].coating = LFLARE_COATING_STACK; p.surfaces[0].first_layer = -1; p.surfaces[0].layer_count = 1;
    expect_refused(&p, "row 1: the coating's layers lie outside the prescription's");
    p.surfaces[0].first_layer = 1024; expect_refused(&p, "row 1: the coating's layers lie outside the prescription's");
    p.surfaces[0].first_layer = INT32_MAX; expect_refused(&p, "row 1: the coating's layers lie outside the prescription's");
    p.surfaces[0].first_layer = 0; p.surfaces[0].layer_count = INT32_MAX; expect_refused(&p, "row 1: the coating's layers lie outside the prescription's");
    p.surfaces[0].layer_count = -1; expect_refused(&p, "row 1: the coating's layers lie outside the prescription's");
    p.surfaces[0].layer_count = 1; expect_refused(&p, "row 1: a layer's index is between 1 and 10");
    p.layers[0].n = 1.38; p.layers[0].thickness_nm = nan; expect_refused(&p, "row 1: a layer is between 0.01 and 100000 nm thick");
    start(&p); p.surfaces[2].radius = 5; expect_refused(&p, "row 3: the stop must be flat");
    start(&p); p.surfaces[0].is_stop = 1; p.surfaces[0].radius = 0; expect_refused(&p, "a second stop (the first is row 1); a lens has one");
    start(&p); p.surfaces[2].is_stop = 0; expect_refused(&p, "there is no stop: add a row 'stop GAP' where the iris is");
    start(&p); p.surfaces[1].medium.kind = LFLARE_MEDIUM_CONSTANT; p.surfaces[1].medium.c[0] = 1.2;
    expect_refused(&p, "the lens ends in glass: the medium behind its last surface must be air");
    start(&p); p.fnumber = nan; expect_refused(&p, "an f-number is between 0.1 and 1000");
    start(&p); p.fnumber = -4; expect_refused(&p, "an f-number is between 0.1 and 1000");
    start(&p); p.sensor_width = nan; expect_refused(&p, "a sensor's side is between 0.01 and 10000 mm");
    start(&p); p.sensor_height = 0; expect_refused(&p, "a sensor's side is between 0.01 and 10000 mm");
    start(&p); p.fnumber = 0; expect_refused(&p, "the aperture is unknown: give 'fnumber', or 'semi' in the stop's row");
    start(&p); memset(p.name, 'x', sizeof p.name); memset(p.surfaces[0].medium.glass, 'x', sizeof p.surfaces[0].medium.glass);
    assert_int_equal(lflare_lens_derive(&p, &lens, NULL), LFLARE_OK); /* labels are nobody's business here */
    start(&p); p.surfaces[0].medium.kind = (lflare_medium_kind)77; /* unknown: air */
    expect_refused(&p, "the lens has no focal length: parallel light leaves it parallel");
    assert_int_equal(lflare_lens_derive(NULL, &lens, NULL), LFLARE_ERROR_ARGUMENT);
    assert_int_equal(lflare_lens_derive(&p, NULL, NULL), LFLARE_ERROR_ARGUMENT);
}

/* Any bytes at all in the numbers of a prescription: an answer, never a crash. */
static void test_made_by_chance(void **state)
{
    static lflare_prescription p;
    static lflare_lens lens;
    lflare_error error;
    int32_t i, derived = 0, k;
    (void)state;
    for (i = 0; i < 20000; i++) {
        uint64_t bits;
        double *numbers[12];
        start(&p);
        numbers[0] = &p.fnumber; numbers[1] = &p.sensor_width; numbers[2] = &p.surfaces[0].radius; numbers[3] = &p.surfaces[0].thickness;
        numbers[4] = &p.surfaces[1].conic; numbers[5] = &p.surfaces[1].aspheric[1]; numbers[6] = &p.surfaces[0].medium.c[0];
        numbers[7] = &p.surfaces[2].semi_diameter; numbers[8] = &p.surfaces[1].radius; numbers[9] = &p.surfaces[0].medium.c[1];
        numbers[10] = &p.surfaces[1].aspheric[0]; numbers[11] = &p.surfaces[1].thickness;
        p.surfaces[0].medium.kind = (lflare_medium_kind)below(5);
        for (k = below(4); k >= 0; k--) {
            bits = chance();
            if (below(3)) *numbers[below(12)] = magnitude(1e-12, 1e12) * (below(2) ? 1 : -1);
            else memcpy(numbers[below(12)], &bits, sizeof bits);
        }
        if (below(4) == 0) p.surface_count = below(400) - 100;
        if (below(8) == 0) p.surfaces[0].first_layer = (int32_t)chance();
        if (below(8) == 0) p.surfaces[0].layer_count = (int32_t)chance();
        if (below(4) == 0) p.surfaces[0].coating = (lflare_coating_kind)below(4);
        k = lflare_lens_derive(&p, &lens, &error);
        assert_true(k == LFLARE_OK || k == LFLARE_ERROR_LENS);
        assert_int_equal(k, error.code);
        if (k != LFLARE_OK) continue;
        assert_true(lens.efl > 0 && lens.efl < 1e300 && lens.fnumber > 0 && lens.fnumber < 1e300 && lens.stop_a11 == lens.stop_a11);
        derived++;
    }
    assert_true(derived > 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_broken),           cmocka_unit_test(test_cut_anywhere),      cmocka_unit_test(test_limits),
        cmocka_unit_test(test_accepted),         cmocka_unit_test(test_values),            cmocka_unit_test(test_round_trip_random),
        cmocka_unit_test(test_round_trip_files), cmocka_unit_test(test_writer_room),       cmocka_unit_test(test_writer_harmless),
        cmocka_unit_test(test_number_round_trip), cmocka_unit_test(test_number_libc),      cmocka_unit_test(test_number_forms),
        cmocka_unit_test(test_comma_locale),     cmocka_unit_test(test_notes),             cmocka_unit_test(test_quarter_and_stack),
        cmocka_unit_test(test_made_by_hand),     cmocka_unit_test(test_made_by_chance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
